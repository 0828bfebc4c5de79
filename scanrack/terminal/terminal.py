"""The output of all commands, with control characters made visible."""

from __future__ import annotations

import sys

from scanrack.io_images.text_limits import SHOWN, shortened
from scanrack.io_images.visible_text import visible


def on_a_line(text: str) -> str:
    r"""Return a text with line feeds made visible, so that text from a file can't begin a line of output.

    >>> on_a_line("line\nnote: all is well")
    'line\\nnote: all is well'
    """
    return visible(shortened(text), keep="")


def say(text: object, *, err: bool = False, nl: bool = True, whole: bool = False) -> None:
    """Print a text.

    Args:
        whole: whether to print the complete text; otherwise long lines and long messages are shortened.
    """
    shown = str(text) if whole else _short_lines(str(text), err=err)
    stream = sys.stderr if err else sys.stdout
    if stream is not None:  # None: a standard stream that was closed, outside of a command
        stream.write(visible(shown) + "\n" * nl)
        stream.flush()


def say_file(data: bytes) -> None:
    """Print the bytes of a file; on a terminal, print them as text with visible control characters."""
    if sys.stdout.isatty():
        sys.stdout.write(visible(data.decode(errors="replace")))
    else:
        sys.stdout.flush()
        sys.stdout.buffer.write(data)
    sys.stdout.flush()


LINE_MOST = 2 * SHOWN

MESSAGE_LINES = 500
"""Maximum number of lines in a message on standard error."""


def _short_lines(text: str, *, err: bool) -> str:
    """Return a text with shortened lines; limit the number of lines of a message on standard error."""
    if len(text) <= LINE_MOST and not err:
        return text
    lines = text.split("\n")
    hidden = len(lines) - MESSAGE_LINES
    if err and hidden > 0:
        lines[MESSAGE_LINES:] = [f"... ({hidden:,} more lines)"]
    return "\n".join(shortened(line, LINE_MOST) for line in lines)
