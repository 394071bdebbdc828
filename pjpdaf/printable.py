"""Text from files and from other people's code, made safe for a terminal."""

from __future__ import annotations

import re

# Colours, erasing and moves of the cursor, as Rich writes them; all other sequences (titles,
# clipboard, links, modes) come from a file or from somebody's code.
_ALLOWED = r"\x1b\[[0-9;]*[mABGJK]|\x1b\[\?25[hl]"
# Control characters but tab, line feed and carriage return; marks that reverse the direction of
# writing; halves of surrogate pairs, which no encoding has.
_UNSAFE = (
    r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
_PATTERN = re.compile(f"({_ALLOWED})|({_UNSAFE})")


def printable(text: str) -> str:
    r"""Replace everything that is not printable by its escape (`\x1b`, `\n`): one line of text."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escape(c) for c in text)


def for_terminal(text: str) -> str:
    """Replace unsafe characters of an output by their escapes; Rich's own sequences stay."""
    if text.isprintable():
        return text
    return _PATTERN.sub(lambda match: match[1] or _escape(match[2]), text)


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
