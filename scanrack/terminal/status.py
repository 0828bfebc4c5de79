"""The exit status of every command, in one table.

    status  name           meaning
    0       DONE           done; or the answer is yes: the same, found, everything held
    1       NO             the answer is no: it differs, nothing found, something broke, the CPU faulted
    2       BAD_INPUT      a file, a key or an option can't be used
    3       CANNOT_WRITE   a file or standard output can't be written
    3       NO_HELPER      a process that `watch` or `--server` needs never began
    3       NOT_SEEN       `fuzz --strict`: something that should be seen sometimes never was
    130     INTERRUPTED    Ctrl-C, SIGTERM or SIGHUP ended it
    141     PIPE_CLOSED    the reader of standard output has gone; no message

130 and 141 are a shell's statuses of a command that SIGINT or SIGPIPE ended: 128 and the signal's number.
"""

from __future__ import annotations

from pathlib import Path

from .terminal import say

DONE = 0
NO = 1
BAD_INPUT = 2
CANNOT_WRITE = 3
NO_HELPER = 3
NOT_SEEN = 3
INTERRUPTED = 130
PIPE_CLOSED = 141


def complain(text: str, status: int = DONE) -> int:
    """Print the program's own message on standard error; return its exit status."""
    say(f"scanrack: {text}", err=True)
    return status


def ignore(_text: str) -> None:
    """Print nothing, in place of `complain`."""


def size_of(path: Path) -> str:
    """Return the size of a file that was just written; another program may have removed it."""
    try:
        return f"{path.stat().st_size:,} bytes"
    except OSError:
        return "no longer there"


def reason(error: OSError) -> str:
    """Return the file and its problem, without the number of the error."""
    problem = error.strerror or str(error)
    return f"{error.filename}: {problem}" if error.filename else problem
