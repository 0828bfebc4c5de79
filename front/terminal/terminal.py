"""The output of commands: the only way to the terminal, with control characters made visible.

Names, messages and metadata come out of files and off lines. An escape sequence in them could move
the cursor, overwrite earlier output, or type at the prompt; an override of the writing
direction reverses a name. A character without a glyph is therefore printed as in Python.
"""

from __future__ import annotations

import sys
import unicodedata

import typer

from ..io_images.text_limits import SHOWN, shortened

LAYOUT = "\n\t"
"""Control characters that are printed unchanged."""

_INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Categories of Unicode: controls, formats, surrogates, private, unassigned, separators of lines."""


def visible(text: str, keep: str = LAYOUT) -> str:
    r"""Return a text with visible control characters.

    >>> visible("\x1b[2Jline\u202e\n")
    '\\x1b[2Jline\\u202e\n'
    """
    if text.isprintable():
        return text
    return "".join(each if each in keep else _visible(each) for each in text)


def _visible(character: str) -> str:
    if unicodedata.category(character) in _INVISIBLE:
        return character.encode("unicode_escape").decode("ascii")
    return character


def on_a_line(text: str) -> str:
    r"""Return a text with visible line feeds, too: a file's text can't begin a line of ours.

    >>> on_a_line("line\nnote: all is well")
    'line\\nnote: all is well'
    """
    return visible(shortened(text), keep="")


def say(text: object, *, err: bool = False, nl: bool = True, whole: bool = False) -> None:
    """Print a text.

    Args:
        whole: print all of it: it is for programs, or our own. Otherwise long lines and long messages
            are shortened.
    """
    shown = str(text) if whole else _short_lines(str(text), err=err)
    typer.echo(visible(shown), err=err, nl=nl)  # noqa: TID251 - the one place


def say_file(data: bytes) -> None:
    """Print the bytes of a file; on a terminal as text with visible control characters."""
    shown = visible(data.decode(errors="replace")) if sys.stdout.isatty() else data
    typer.echo(shown, nl=False)  # noqa: TID251 - the one place


LINE_MOST = 2 * SHOWN

MESSAGE_LINES = 500
"""Most lines of a message on standard error."""


def _short_lines(text: str, *, err: bool) -> str:
    if len(text) <= LINE_MOST and not err:
        return text
    lines = text.split("\n")
    more = len(lines) - MESSAGE_LINES
    if err and more > 0:
        lines[MESSAGE_LINES:] = [f"... ({more:,} more lines)"]
    return "\n".join(shortened(line, LINE_MOST) for line in lines)
