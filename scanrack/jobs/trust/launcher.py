"""Starts all helper processes. No other file starts helpers.

    python -P -c BOOT COUNT FOLDER... CHUNK_BYTES RECORDS HANDED MODULE:FUNCTION ARGUMENT...

`python -c` and `python -m` first search the current folder for modules, and would run another person's
`json.py` there. -P prevents that. A helper receives the search path of this process before it imports
anything, and the limits for reading traces before it begins.

Sockets and shared memory are passed to a helper on its standard input, as a pickled list of tickets. The
helper opens the socket or shared memory of a ticket:

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
"""Size of a shared memory block in bytes, or None for a socket; and its number, name or description."""

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
        handed: sockets and shared memory blocks to pass to the helper; if there are any, `stdin` is not used.
        stdin: as for `subprocess.Popen`; empty by default.
        stdout: as for `subprocess.Popen`; this process's by default.
        stderr: as for `subprocess.Popen`; this process's by default.
        environment: environment variables of the helper; None = the same as in this process.
        own_session: whether to protect it from the terminal's Ctrl-C. Ctrl-Break on Windows never ends it.
    """
    path = [entry for entry in sys.path if entry]  # "" is the current folder
    own_limits = limits()
    words = [*path, own_limits.chunk_bytes, own_limits.records, len(handed), main, *arguments]
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
        with suppress(OSError), process.stdin as tickets:  # the caller notices a dead process later
            tickets.write(pickle.dumps([_ticket(resource, process.pid) for resource in handed]))
        process.stdin = None  # for `communicate`
    return process


def _python(environment: dict[str, str] | None) -> tuple[str, dict[str, str] | None]:
    """Return the path of Python, and environment variables for it.

    In a Windows virtual environment, `python.exe` starts another process, which could not use the tickets.
    Like `multiprocessing` in the standard library, this starts the other Python directly.
    """
    started: str = vars(sys)["_base_executable"]
    if sys.platform == "win32" and started != sys.executable:
        environment = (environment or dict(os.environ)) | {"__PYVENV_LAUNCHER__": sys.executable}
    else:
        started = sys.executable
    return started, environment


def _ticket(resource: Handed, pid: int) -> Ticket:
    """Return a ticket that lets another process open a shared memory block or socket."""
    if isinstance(resource, SharedMemory):
        return resource.size, resource.handle
    if sys.platform == "win32":
        place: int | bytes = resource.share(pid)
    else:
        place = resource.fileno()
    return None, place


def _opened(ticket: Ticket) -> Handed:
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
    """Return Python's options: no search of the current folder, and this process's ignored warnings."""
    if sys.flags.isolated:
        return ["-I"]
    flags = {"-E": sys.flags.ignore_environment, "-s": sys.flags.no_user_site}
    return ["-P", *(option for option, on in flags.items() if on)]


def begin(words: list[str]) -> None:
    """Set the limits and call the helper's function; `words` are the arguments after the folders."""
    if hasattr(signal, "SIGBREAK"):  # Ctrl-Break reaches all processes of a console; the parent ends this one
        signal.signal(signal.SIGBREAK, signal.SIG_IGN)
    chunk_bytes, records, handed, main, *arguments = words
    set_limits(Limits(int(chunk_bytes), int(records)))
    tickets = pickle.load(sys.stdin.buffer) if int(handed) else ()  # only the parent process writes there
    module, _, function = main.partition(":")
    getattr(import_module(module), function)(*map(_opened, tickets), *arguments)
