"""Python's modules as they are on Windows, for the modules of scanrack only.

import os     in scanrack    a stand-in for `os`, without what Windows lacks, and with what it has besides
              elsewhere      `os`
import fcntl  in scanrack    there is none
"""

from __future__ import annotations

import asyncio
import builtins
import fcntl
import io
import mmap
import os
import pickle
import select
import selectors
import signal
import socket
import stat
import sys
import types
from collections.abc import Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from multiprocessing.reduction import DupFd
from typing import Any

from forked import Python

OURS = "scanrack"

GONE = {
    "crypt",
    "curses",
    "fcntl",
    "grp",
    "posix",
    "pty",
    "pwd",
    "readline",
    "resource",
    "syslog",
    "termios",
    "tty",
}
"""Modules that Windows does not have."""

LACKS = {
    "os": """
        chown chroot copy_file_range ctermid eventfd fchdir fchmod fchown fdatasync fork forkpty
        get_blocking getegid geteuid getgid getgroups getloadavg getpgid getpgrp getpriority getsid
        getuid initgroups killpg lchown lockf login_tty memfd_create mkfifo mknod nice openpty
        pidfd_open pipe2 posix_fallocate posix_spawn pread preadv pwrite pwritev readv register_at_fork
        sendfile set_blocking setgid setpgid setpriority setsid setuid splice statvfs sync sysconf
        tcgetpgrp tcsetpgrp ttyname uname wait wait3 wait4 writev O_CLOEXEC O_DIRECTORY O_NOFOLLOW
        O_NONBLOCK O_PATH O_TMPFILE WEXITSTATUS WIFEXITED WIFSIGNALED WNOHANG WTERMSIG
    """,
    "signal": """
        ITIMER_PROF ITIMER_REAL ITIMER_VIRTUAL SIGALRM SIGCHLD SIGCONT SIGHUP SIGKILL SIGPIPE SIGQUIT
        SIGSTOP SIGTSTP SIGTTIN SIGTTOU SIGUSR1 SIGUSR2 SIGWINCH alarm getitimer pause pthread_kill
        pthread_sigmask setitimer siginterrupt sigpending sigwait
    """,
    "socket": """
        AF_CAN AF_PACKET AF_UNIX MSG_DONTWAIT MSG_NOSIGNAL SCM_RIGHTS SO_BINDTODEVICE SO_REUSEPORT
        TCP_QUICKACK recv_fds send_fds
    """,
    "select": "EPOLLIN POLLIN epoll poll",
    "selectors": "EpollSelector PollSelector",
    "time": "clock_getres clock_gettime clock_gettime_ns clock_settime pthread_getcpuclockid tzset",
    "mmap": "MAP_ANONYMOUS MAP_PRIVATE MAP_SHARED PROT_READ PROT_WRITE",
    "sys": "abiflags",
}
"""Names that modules do not have on Windows; of `os`, all that begin with `sched_`, too."""

CTRL_C, CTRL_BREAK = 0, 1
BREAK = signal.SIGQUIT
"""Stands for SIGBREAK, the signal of Ctrl-Break."""

NEW_GROUP = 0x200

MEMORY = "SCANRACK_TEST_MEMORY"
"""Variable that names the folder for memory with a name."""


class StandIn:
    """A module without some names, and with others."""

    def __init__(self, module: types.ModuleType, has: Mapping[str, object]) -> None:
        lacks = set(LACKS.get(module.__name__, "").split())
        vars(self).update(has, _module=module, _lacks=lacks)

    def __getattr__(self, name: str) -> Any:
        if name in self._lacks or name.startswith("sched_"):
            raise AttributeError(f"module {self._module.__name__!r} has no attribute {name!r} on Windows")
        return getattr(self._module, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._module, name, value)


class Popen(Python):
    """Starts a process: no files but the three standard ones go to it."""

    def __init__(self, words: Sequence[str], *, creationflags: int = 0, **options: Any) -> None:
        for each in ("pass_fds", "preexec_fn"):
            if options.pop(each, None):
                raise ValueError(f"{each} is not supported on Windows")
        options["process_group"] = 0 if creationflags & NEW_GROUP else -1
        options.pop("start_new_session", None)
        super().__init__(words, **options)

    def send_signal(self, number: int) -> None:
        """Send a signal that Windows has."""
        if number == CTRL_BREAK:
            os.killpg(self.pid, BREAK)
        elif number in (CTRL_C, signal.SIGTERM):
            self.kill()
        else:
            raise ValueError(f"Unsupported signal: {number}")

    def terminate(self) -> None:
        """End the process at once: it is not asked."""
        super().send_signal(signal.SIGKILL)

    kill = terminate


def _kill(pid: int, number: int) -> None:
    assert number != CTRL_C, "os.kill(pid, 0) is Ctrl-C on Windows"
    os.kill(pid, BREAK if number == CTRL_BREAK else signal.SIGKILL)


class _Text(io.TextIOWrapper):
    def __init__(self, buffer: Any, encoding: str | None = None, *more: Any, **options: Any) -> None:
        super().__init__(buffer, encoding or "cp1252", *more, **{"newline": "\r\n"} | options)


def _select(read: Any, write: Any, other: Any, timeout: float | None = None) -> Any:
    for each in (*read, *write, *other):
        number = each if isinstance(each, int) else each.fileno()
        if not stat.S_ISSOCK(os.fstat(number).st_mode):
            raise OSError(10038, "An operation was attempted on something that is not a socket")
    return select.select(read, write, other, timeout)


class _Selector(selectors.SelectSelector):
    def _select(self, r: Any, w: Any, _: Any, timeout: float | None = None) -> Any:
        return *_select(r, w, w, timeout)[:2], []


def _locking(number: int, mode: int, _bytes: int) -> None:
    """Do what `msvcrt.locking` does, whatever the bytes: it is exclusive, and tried at once."""
    flag = fcntl.LOCK_UN if mode == 0 else fcntl.LOCK_EX | fcntl.LOCK_NB
    try:
        fcntl.flock(number, flag)
    except BlockingIOError:
        raise PermissionError(13, "Permission denied") from None


MSVCRT = types.ModuleType("msvcrt")
vars(MSVCRT).update(LK_UNLCK=0, LK_LOCK=1, LK_NBLCK=2, locking=_locking)


def _mmap(number: int, size: int, tagname: str | None = None, **options: Any) -> mmap.mmap:
    if tagname is None:
        return mmap.mmap(number, size, **options)
    number = os.open(f"{os.environ[MEMORY]}/{tagname}", os.O_RDWR | os.O_CREAT, 0o600)
    try:
        os.ftruncate(number, size)
        return mmap.mmap(number, size)
    finally:
        os.close(number)


def _share(self: socket.socket, _process: int) -> bytes:
    return pickle.dumps(DupFd(self.fileno()))


def _fromshare(data: bytes) -> socket.socket:
    return socket.socket(fileno=pickle.loads(data).detach())


class _Loop(asyncio.SelectorEventLoop):
    """The loop of asyncio that Windows takes by default: it watches no files."""


def _refuse(*_: object) -> Any:
    raise NotImplementedError


for _name in ("reader", "writer", "signal_handler"):
    setattr(_Loop, f"add_{_name}", _refuse)
    setattr(_Loop, f"remove_{_name}", _refuse)

HAS: dict[str, dict[str, Any]] = {
    "os": {"name": "nt", "linesep": "\r\n", "kill": _kill, "O_BINARY": 0, "O_NOINHERIT": 0},
    "sys": {"platform": "win32", "_base_executable": sys.executable},
    "signal": {"SIGBREAK": BREAK, "CTRL_C_EVENT": CTRL_C, "CTRL_BREAK_EVENT": CTRL_BREAK},
    "socket": {"SO_EXCLUSIVEADDRUSE": socket.SO_REUSEADDR, "fromshare": _fromshare},
    "select": {"select": _select},
    "selectors": {"DefaultSelector": _Selector},
    "subprocess": {"Popen": Popen, "CREATE_NEW_PROCESS_GROUP": NEW_GROUP},
    "io": {"TextIOWrapper": _Text},
    "asyncio": {},
    "time": {},
    "mmap": {"mmap": _mmap},
}
"""What modules have on Windows, in place of what is here or besides it."""

_stand_ins: dict[str, StandIn] = {}
_import = builtins.__import__


def _imported(name: str, globals: Any = None, locals: Any = None, names: Any = (), level: int = 0) -> Any:
    """Import a module of Windows."""
    if level:
        return _import(name, globals, locals, names, level)
    if name == "msvcrt":
        return MSVCRT
    if name.partition(".")[0] in GONE:
        raise ModuleNotFoundError(f"No module named {name!r} on Windows", name=name)
    module = _import(name, globals, locals, names, level)
    key = module.__name__
    if key not in HAS:
        return module
    if key not in _stand_ins:
        _stand_ins[key] = StandIn(module, HAS[key])
    return _stand_ins[key]


class _Loader(SourceFileLoader):
    def exec_module(self, module: types.ModuleType) -> None:
        vars(module)["__builtins__"] = {**vars(builtins), "__import__": _imported}
        super().exec_module(module)


class _Finder:
    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find a module of scanrack."""
        if name.partition(".")[0] != OURS:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


def take_modules_of_windows() -> None:
    """Let scanrack be imported again, and find Windows."""
    for name in [each for each in sys.modules if each.partition(".")[0] == OURS]:
        del sys.modules[name]
    sys.meta_path.insert(0, _Finder)
    socket.socket.share = _share  # type: ignore[attr-defined]
    asyncio.new_event_loop = asyncio.events.new_event_loop = _Loop
