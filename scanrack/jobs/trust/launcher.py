"""Starts helper processes; no other file does so.

    python -P -c BOOT COUNT FOLDER... CHUNK_BYTES RECORDS HANDED MODULE:FUNCTION ARGUMENT...

With `python -c` and `python -m`, Python first searches the current folder for modules, so a stranger's
`json.py` there would run. -P prevents that. A helper receives the search path of this process before it
imports anything, and the limits for reading traces before it begins.

Sockets and shared memory are passed to a helper on its standard input, as a pickled list of tickets. With a
ticket, the other side opens a socket or shared memory:

    POSIX     the number of a file descriptor that the helper inherits
    Windows   the description of a socket, for this helper only; the name of the memory
"""

from __future__ import annotations

import os
import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from subprocess import PIPE, TimeoutExpired
from typing import IO

from scanrack.runtime.live.shared_memory import SharedMemory
from scanrack.traces.format.limits import Limits, limits, set_limits

__all__ = ["PIPE", "Handed", "Helper", "TimeoutExpired", "begin", "launch"]

Helper = subprocess.Popen[bytes]
Stream = int | IO[bytes] | None
Handed = socket.socket | SharedMemory

Ticket = tuple[int | None, int | str | bytes]
"""Size of a shared memory, or None for a socket; and a number, a name or a description."""

BOOT = (
    "import sys; count = int(sys.argv[1]); sys.path[:] = sys.argv[2 : 2 + count]; "
    f"from {__name__} import begin; begin(sys.argv[2 + count :])"
)
"""The first code that a helper runs; `sys` is built in."""


def launch(
    main: str,
    *arguments: object,
    handed: Sequence[Handed] = (),
    stdin: Stream = subprocess.DEVNULL,
    stdout: Stream = None,
    stderr: Stream = None,
    environment: dict[str, str] | None = None,
    own_session: bool = False,
) -> Helper:
    """Start a helper; raise OSError if it can't be started.

    Args:
        main: the function to call, `module:function`, with the handed objects and the arguments as strings.
        handed: sockets and shared memories that both processes then have; if any, `stdin` is not used.
        stdin: as for `subprocess.Popen`; empty by default.
        stdout: ours by default.
        stderr: ours by default.
        environment: environment variables of the helper; None = ours.
        own_session: whether to shield it from the terminal's Ctrl-C; Windows' Ctrl-Break never ends it.
    """
    path = [entry for entry in sys.path if entry]  # "" is the current folder
    server_limits = limits()
    words = [*path, server_limits.chunk_bytes, server_limits.records, len(handed), main, *arguments]
    python, environment = _python(environment)
    process = subprocess.Popen(
        [python, *_flags(), "-c", BOOT, str(len(path)), *map(str, words)],
        stdin=PIPE if handed else stdin,
        stdout=stdout,
        stderr=stderr,
        env=environment,
        pass_fds=[] if sys.platform == "win32" else [int(_ticket(resource, 0)[1]) for resource in handed],
        start_new_session=own_session,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0) if own_session else 0,
    )
    if process.stdin is not None and handed:
        with suppress(OSError), process.stdin as tickets:  # a dead process is noticed later
            tickets.write(pickle.dumps([_ticket(resource, process.pid) for resource in handed]))
        process.stdin = None  # for `communicate`
    return process


def _python(environment: dict[str, str] | None) -> tuple[str, dict[str, str] | None]:
    """Return the path of Python, and environment variables for it.

    In a Windows virtual environment, `python.exe` starts another process, and the tickets would have to be
    for that process. Like `multiprocessing` in the standard library, this starts that Python directly.
    """
    started: str = vars(sys)["_base_executable"]
    if sys.platform == "win32" and started != sys.executable:
        environment = (environment or dict(os.environ)) | {"__PYVENV_LAUNCHER__": sys.executable}
    else:
        started = sys.executable
    return started, environment


def _ticket(each: Handed, pid: int) -> Ticket:
    """Return a ticket with which another process can open a shared memory or socket."""
    if isinstance(each, SharedMemory):
        return each.size, each.handle
    if sys.platform == "win32":
        place: int | bytes = each.share(pid)
    else:
        place = each.fileno()
    return None, place


def _taken(ticket: Ticket) -> Handed:
    """Open the shared memory or socket of a ticket, in the helper."""
    size, place = ticket
    if size is not None:
        assert not isinstance(place, bytes)
        return SharedMemory(size, place)
    if sys.platform == "win32":
        assert isinstance(place, bytes)
        received = socket.fromshare(place)
    else:
        received = socket.socket(fileno=int(place))
    return received


def _flags() -> list[str]:
    """Return Python's options: no search of the current folder, and the same ignored warnings as here."""
    if sys.flags.isolated:
        return ["-I"]
    flags = {"-E": sys.flags.ignore_environment, "-s": sys.flags.no_user_site}
    return ["-P", *(option for option, on in flags.items() if on)]


def begin(words: list[str]) -> None:
    """Set the limits and call the function: the main function of a helper. For `words`, see `BOOT`."""
    if hasattr(signal, "SIGBREAK"):  # Ctrl-Break reaches all processes of a console; the parent ends this one
        signal.signal(signal.SIGBREAK, signal.SIG_IGN)
    chunk_bytes, records, handed, main, *arguments = words
    set_limits(Limits(int(chunk_bytes), int(records)))
    arguments_taken = map(_taken, pickle.load(sys.stdin.buffer)) if int(handed) else ()  # from our own parent
    module, _, function = main.partition(":")
    getattr(import_module(module), function)(*arguments_taken, *arguments)
