"""The help of the verbs: whole sentences, as wide as the terminal."""

from __future__ import annotations

import shutil
from typing import Any

from typer import Context
from typer.core import TyperGroup

MOST_COLUMNS = 120  # longer lines are hard to read
NARROW_COLUMNS = 52  # Typer's formatter takes no terminal to be narrower
INDENT_COLUMNS = 6  # of a sentence that stands below its name
WHOLE_HYPHEN = "\N{NON-BREAKING HYPHEN}"  # stands for a hyphen while lines are broken
CONTEXT = {"max_content_width": MOST_COLUMNS}


# The class has no public name.
class HelpFormatter(Context.formatter_class):  # type: ignore[misc, valid-type]
    """A formatter that fits any terminal; on a narrow one a sentence stands below its name.

    No line ends inside a word, such as a name with hyphens.
    """

    def __init__(self, **settings: Any) -> None:
        columns = shutil.get_terminal_size().columns
        self.narrow = columns < NARROW_COLUMNS
        super().__init__(**settings | ({"width": columns - 1} if self.narrow else {}))

    def write(self, string: str) -> None:
        """Write a piece of text as it is."""
        super().write(string.replace(WHOLE_HYPHEN, "-"))

    def write_text(self, text: str) -> None:
        """Write paragraphs."""
        super().write_text(text.replace("-", WHOLE_HYPHEN))

    def write_dl(self, rows: Any, col_max: int = 30, col_spacing: int = 2) -> None:
        """Write a list of names, each with its sentence."""
        if self.narrow:
            col_max = INDENT_COLUMNS - col_spacing - self.current_indent
        whole = [(name, sentence.replace("-", WHOLE_HYPHEN)) for name, sentence in rows]
        super().write_dl(whole, col_max, col_spacing)


class HelpContext(Context):
    """The context of a verb whose help fits the terminal."""

    formatter_class = HelpFormatter


class SentenceGroup(TyperGroup):
    """A group whose list of verbs has their first sentences, however many lines these take."""

    context_class = HelpContext

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The verb of this name, with help that fits the terminal."""
        verb = super().get_command(ctx, cmd_name)
        if verb is not None:
            verb.context_class = HelpContext
        return verb

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
