"""The one Jinja environment of all pages, their styles and scripts, and the writing of a page."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from reports.summary.tables import time_text
from reports.summary.text import number, percent
from reports.words import LABELS
from sim.files import disk_faults, written_whole_file


def rendered(template: str, **values: Any) -> str:
    """Render a template of the folder `templates`; all but Markdown escapes its values as HTML."""
    return _environment().get_template(template).render(**values)


def asset(*names: str) -> Markup:
    """Files of the folder `templates` one after the other, to stand in a page as they are."""
    folder = resources.files("reports") / "page" / "templates"
    return Markup("\n".join((folder / name).read_text(encoding="utf-8") for name in names))


def styles(*own: str) -> Markup:
    """The style of a page: the look of all pages, then its own files, then that of paper."""
    return asset("page.css", "tables.css", "sections.css", "charts.css", *own, "print.css")


def script(*names: str) -> Markup:
    """JavaScript files in one scope of their own, in this order.

    A page opened from disk cannot import modules; so its parts are put together here, and what
    one declares the next ones use.
    """
    return Markup('"use strict";\n(() => {\n') + asset(*names) + Markup("\n})();\n")


def shared_scripts() -> list[Markup]:
    """The scripts of all pages: sorting and columns of tables, folds and contents, search."""
    return [script("tables.js"), script("folds.js"), script("search.js")]


def write_text(path: Path, text: str) -> Path:
    """Write a page, whole or not at all, and return its path. Raises BenchError."""
    return write_made(path, lambda: text)


def write_made(path: Path, make: Callable[[], str]) -> Path:
    """Make a page and write it as `write_text` does; a place that cannot be written comes first."""
    noun = "the report"
    with written_whole_file(path, noun, replace=True) as part:
        text = make()
        with disk_faults(path, noun):
            part.write_text(text, encoding="utf-8")
    return path


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "page/templates"),
        autoescape=lambda name: name is None or not name.endswith(".md.j2"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_shares_kept_whole,
    )
    environment.filters.update(
        number=number,
        percent=percent,
        time_text=time_text,
        label=LABELS.__getitem__,
        plain_value=plain_value,
        share=_share,
        group_title=group_title,
        plain_markdown=plain_markdown,
        shell=shlex.join,
        words=words_kept_whole,
        parted=parted_name,
    )
    return environment


@jinja2.pass_eval_context
def _shares_kept_whole(context: jinja2.nodes.EvalContext, value: Any) -> Any:
    """A value to print; in HTML text no line ends between a number and its "%"."""
    if context.autoescape and type(value) is str:
        return value.replace(" %", "\N{NO-BREAK SPACE}%")
    return value


def plain_value(value: Any) -> str:
    """A value of run.json for reading: text as it is, all else as JSON."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def words_kept_whole(command: str) -> Markup:
    """A command in which lines end between words alone, not behind the hyphens of an option."""
    return Markup(" ").join(Markup("<span>{}</span>").format(word) for word in command.split(" "))


def parted_name(name: str) -> Markup:
    """A name in which a line ends behind an underscore, where it has to."""
    return escape(name).replace("_", Markup("_<wbr>"))


def group_title(group: str) -> str:
    """A group's name for reading, such as "Hand and head"."""
    return group.replace("_", " ").capitalize()


def plain_markdown(text: str) -> str:
    """Escape text for one line of Markdown."""
    return re.sub(r"([\\`*\[\]|<>])", r"\\\1", " ".join(text.split()))


def _share(value: float) -> str:
    """A share 0-1 with three digits, "-" for nothing to measure."""
    return "-" if value != value else f"{value:.3f}"
