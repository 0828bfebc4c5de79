"""The exit status of every command, in one table.

    status  name           meaning
    0       DONE           done; or the answer is yes: the same, found, everything held
    1       NO             the answer is no: it differs, nothing found, something broke, the CPU faulted
    2       BAD_INPUT      a file, a key or an option can't be used
    3       CANNOT_WRITE   a file or standard output can't be written
    130     INTERRUPTED    Ctrl-C, SIGTERM or SIGHUP ended it
    141     PIPE_CLOSED    the reader of standard output has gone; nothing is said

130 and 141 are what a shell shows of a command that SIGINT or SIGPIPE ended: 128 and the signal's number.
"""

from __future__ import annotations

DONE = 0
NO = 1
BAD_INPUT = 2
CANNOT_WRITE = 3
INTERRUPTED = 130
PIPE_CLOSED = 141
