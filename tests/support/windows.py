"""Commands as on Windows: processes of this system in which scanrack finds what Windows has.

    test ──> Windows: imports scanrack once ──fork──> a command ──> its helpers
                                            └─fork──> the next one

What `windows_modules` and `windows_files` do not imitate is not tested: separators, drives, handles,
consoles.
A command has ended when all its helpers have, too; those that do not end are named.
"""

from __future__ import annotations

import contextlib
import ctypes
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from time import monotonic, sleep
from typing import IO, Any, NamedTuple

import forked
from windows_files import CODE_PAGE, take_files_of_linux
from windows_modules import BREAK, MEMORY, take_modules_of_windows

ADOPT_ORPHANS = 36
"""PR_SET_CHILD_SUBREAPER: who is left by its parent becomes this process's child [prctl(2)]."""

COMMAND = "import windows; windows.take_streams(); from scanrack.__main__ import main; main()"

PATIENCE_S = 120.0


class Done(NamedTuple):
    """What has come of a command: its status, what it wrote, and the processes that did not end."""

    status: int
    out: str
    err: str
    left: list[str]


class Windows:
    """A process of Windows that runs commands, in turn."""

    def __init__(self) -> None:
        pipe = subprocess.PIPE
        words = [sys.executable, "-c", "import windows; windows.answer()"]
        self._process = forked.start(words, stdin=pipe, stdout=pipe, text=True, encoding="utf-8")

    def __enter__(self) -> Windows:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()

    def run(self, words: Sequence[str], folder: Path) -> Done:
        """Run `scanrack` with some words in a folder, without input."""
        print(json.dumps([*words, str(folder)]), file=self._process.stdin, flush=True)
        assert self._process.stdout is not None
        return Done(*json.loads(self._process.stdout.readline()))


@contextlib.contextmanager
def start(words: Sequence[object], **options: Any) -> Iterator[subprocess.Popen[Any]]:
    """Start `scanrack` as on Windows in a process by itself; Ctrl-C and Ctrl-Break (`BREAK`) go on to it."""
    with forked.start([sys.executable, "-c", "import windows; windows.keep()", *words], **options) as process:
        try:
            yield process
        except BaseException:
            process.send_signal(BREAK)  # a test that fails waits for it, too
            raise


def answer() -> None:
    """Run the commands that are asked for on standard input."""
    with _windows():
        commands = import_module("scanrack.commands")
        for entry in commands.COMMANDS.values():
            import_module(entry.module, commands.__name__)
        for line in sys.stdin:
            *words, folder = json.loads(line)
            with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
                streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": out, "stderr": err}
                status, left = _ended(
                    forked.Python([sys.executable, "-c", COMMAND, *words], cwd=folder, **streams)
                )
                sys.stdout.write(json.dumps([status, _text(out), _text(err), left]) + "\n")
                sys.stdout.flush()


def keep() -> None:
    """Run one command, and end as it does when no process of its is left."""
    with _windows():
        command = forked.Python([sys.executable, "-c", COMMAND, *sys.argv[1:]], start_new_session=True)
        signal.signal(signal.SIGINT, lambda got, _: os.killpg(command.pid, got))
        signal.signal(BREAK, lambda got, _: _send_to_session(command.pid, got))
        status, left = _ended(command)
        for each in left:
            sys.stderr.write(f"left behind: {each}\n")
        sys.exit(-1 if left else status)


def _send_to_session(session: int, number: int) -> None:
    """Send a signal to all processes of a session, whatever their groups: a console's Ctrl-Break."""
    for each in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if os.getsid(int(each.name)) == session:
                os.kill(int(each.name), number)


def take_streams() -> None:
    """Have the standard streams of a process of Windows that are files or pipes."""
    sys.argv[0] = "scanrack"
    sys.stdin = open(0, encoding=CODE_PAGE, closefd=False)  # noqa: SIM115
    sys.stdout, sys.stderr = _output(1, "strict"), _output(2, "backslashreplace")


@contextlib.contextmanager
def _windows() -> Iterator[None]:
    ctypes.CDLL(None).prctl(ADOPT_ORPHANS, 1, 0, 0, 0)
    with tempfile.TemporaryDirectory() as memory:
        os.environ[MEMORY] = memory
        take_files_of_linux()
        take_modules_of_windows()
        yield


def _output(number: int, errors: str) -> IO[str]:
    file = open(number, "wb", closefd=False)  # noqa: SIM115
    return io.TextIOWrapper(file, CODE_PAGE, errors, newline="\r\n", line_buffering=number == 2)


def _text(file: IO[bytes]) -> str:
    """Return what a command wrote; what is no UTF-8 shows."""
    file.seek(0)
    return file.read().decode(errors="backslashreplace")


def _ended(command: subprocess.Popen[Any]) -> tuple[int, list[str]]:
    """Wait for a command and all processes below; return the status, and which of them had to be killed."""
    status = command.wait()
    end = monotonic() + PATIENCE_S
    while (left := list(_children())) and monotonic() < end:
        sleep(0.01)
    for pid, _ in left:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    return status, [name for _, name in left]


def _children() -> Iterator[tuple[int, str]]:
    """Yield the processes below this one that live, and bury the dead."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if f"\nPPid:\t{os.getpid()}\n" in (folder / "status").read_text(encoding="utf-8"):
                yield int(folder.name), (folder / "cmdline").read_text(encoding="utf-8").replace("\0", " ")
