"""Starts helper processes; no other file starts one.

    python -P -c BOOT COUNT FOLDER... CHUNK_BYTES RECORDS MODULE:FUNCTION ARGUMENT...

Python searches the current folder first for the modules of `python -c` and `python -m`, so that a stranger's
`json.py` there would run. -P prevents that. A helper receives the search path of this process before it
imports anything, and the limits for reading traces before it begins.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Collection
from importlib import import_module
from subprocess import PIPE, TimeoutExpired
from typing import IO

from ...traces.format.limits import Limits, limits, set_limits

__all__ = ["PIPE", "Helper", "TimeoutExpired", "begin", "launch"]

Helper = subprocess.Popen[bytes]
Stream = int | IO[bytes] | None

BOOT = (
    "import sys; count = int(sys.argv[1]); sys.path[:] = sys.argv[2 : 2 + count]; "
    f"from {__name__} import begin; begin(sys.argv[2 + count :])"
)
"""The first code of a helper; `sys` is built in."""


def launch(
    main: str,
    *arguments: object,
    stdin: Stream = subprocess.DEVNULL,
    stdout: Stream = None,
    stderr: Stream = None,
    environment: dict[str, str] | None = None,
    pass_fds: Collection[int] = (),
    own_session: bool = False,
) -> Helper:
    """Start a helper; OSError if it can't be started.

    Args:
        main: the function to call, `module:function`, with its arguments as texts.
        stdin: as for `subprocess.Popen`; nothing by default.
        stdout: ours by default.
        stderr: ours by default.
        environment: its environment variables; None = ours.
        own_session: whether Ctrl-C of the terminal does not reach it.
    """
    path = [each for each in sys.path if each]  # the empty one is the current folder
    asked = limits()
    words = [*path, asked.chunk_bytes, asked.records, main, *arguments]
    return subprocess.Popen(
        [sys.executable, *_flags(), "-c", BOOT, str(len(path)), *map(str, words)],
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        env=environment,
        pass_fds=pass_fds,
        start_new_session=own_session,
    )


def _flags() -> list[str]:
    """Return Python's options: no current folder, and the warnings that this process ignores."""
    if sys.flags.isolated:
        return ["-I"]
    given = {"-E": sys.flags.ignore_environment, "-s": sys.flags.no_user_site}
    return ["-P", *(option for option, on in given.items() if on)]


def begin(words: list[str]) -> None:
    """Set the limits and call the function: the main function of a helper; for `words` see `BOOT`."""
    chunk_bytes, records, main, *arguments = words
    set_limits(Limits(int(chunk_bytes), int(records)))
    module, _, function = main.partition(":")
    getattr(import_module(module), function)(*arguments)
