"""The exit statuses of all commands.

    status  name           meaning
    0       DONE           done; or the result is yes: equal, found, everything is true
    1       NO             the result is no: different, nothing found, something is false, the CPU faulted
    2       BAD_INPUT      a file, a key or an option can't be used
    3       CANNOT_WRITE   a file or standard output can't be written
    3       NO_HELPER      a process that `watch` or `--server` needs has not started
    3       NOT_SEEN       `fuzz --strict`: a `sometimes` condition was never true
    130     INTERRUPTED    Ctrl-C, SIGTERM or SIGHUP ended it
    141     PIPE_CLOSED    the reader of standard output has closed it; no message

130 and 141 are a shell's statuses for a command that SIGINT or SIGPIPE ended: 128 + signal number.
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
    """Print a message of scanrack on standard error; return the exit status."""
    say(f"scanrack: {text}", err=True)
    return status


def complain_of_helper() -> int:
    """Print that a helper process has not started, which has printed its error; return the exit status."""
    return complain("a helper process has not started: see its error above", NO_HELPER)


def ignore(_text: str) -> None:
    """Print nothing. Used in place of `complain`."""


def size_of(path: Path) -> str:
    """Return the size of a file that was just written; another program may have removed it."""
    try:
        return f"{path.stat().st_size:,} bytes"
    except OSError:
        return "no longer there"


def reason(error: OSError) -> str:
    """Return the file and its problem, without the error number."""
    problem = error.strerror or str(error)
    return f"{error.filename}: {problem}" if error.filename else problem
