"""The help of a group of verbs: a whole sentence for each verb, as wide as the terminal."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

MOST_COLUMNS = 120  # longer lines are hard to read
CONTEXT = {"max_content_width": MOST_COLUMNS}


class SentenceGroup(TyperGroup):
    """A group whose list of verbs has their first sentences, however many lines these take."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list."""
        verbs = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        rows = [
            (name, verb.get_short_help_str(limit=10_000))
            for name, verb in verbs.items()
            if verb is not None and not verb.hidden
        ]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
