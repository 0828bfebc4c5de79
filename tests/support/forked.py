"""Python in a process of its own that is forked from this one, with all its modules: it starts at once.

A test whose point is that Python starts, or where it finds its modules, uses `subprocess`.
"""

from __future__ import annotations

import gc
import os
import runpy
import signal
import subprocess
import sys
import threading
import traceback
import types
import warnings
from collections.abc import Collection, Mapping, Sequence
from typing import Any, NoReturn

from scanrack.jobs.trust import launcher

HASHES = "PYTHONHASHSEED"


class Python(subprocess.Popen[Any]):
    """What `subprocess.Popen` is, of `python [-P] -c CODE ...` and `python [-P] -m MODULE ...` only.

    Helpers that the process starts are forked from it, too.
    """

    def _execute_child(  # private: the one place where a Popen starts a process
        self,
        args: Sequence[str],
        executable: object,
        preexec_fn: object,
        close_fds: bool,
        pass_fds: Collection[int],
        cwd: str | None,
        env: Mapping[str, str] | None,
        startupinfo: object,
        creationflags: object,
        shell: object,
        p2cread: int,
        p2cwrite: int,
        c2pread: int,
        c2pwrite: int,
        errread: int,
        errwrite: int,
        restore_signals: object,
        gid: object,
        gids: object,
        uid: object,
        umask: object,
        start_new_session: bool,
        process_group: int,
        *others: object,
    ) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            self.pid = os.fork()
        if not self.pid:
            streams = (p2cread, c2pwrite, errwrite)
            if start_new_session:
                os.setsid()
            elif process_group != -1:
                os.setpgid(0, process_group)
            _become(list(map(str, args)), streams, pass_fds, cwd, env)
        self._child_created = True
        self._close_pipe_fds(p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite)  # type: ignore[attr-defined]


def fork_helpers() -> None:
    """Let the helpers of this process, and those of its forks, be forked."""
    launcher.subprocess = types.SimpleNamespace(**vars(subprocess) | {"Popen": start})  # type: ignore[assignment]


def run(words: Sequence[object], **options: Any) -> subprocess.CompletedProcess[Any]:
    """Do what `subprocess.run` does."""
    check, given, timeout = (options.pop(name, None) for name in ("check", "input", "timeout"))
    if options.pop("capture_output", False):
        options |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    if given is not None:
        options["stdin"] = subprocess.PIPE
    with start(words, **options) as process:
        out, err = process.communicate(given, timeout)
    done = subprocess.CompletedProcess(process.args, process.returncode, out, err)
    if check:
        done.check_returncode()
    return done


def start(words: Sequence[object], **options: Any) -> subprocess.Popen[Any]:
    """Start a process: forked, unless this system can't fork or the order of its sets is to be another."""
    environment = options.get("env") or os.environ
    same_order = environment.get(HASHES) == os.environ.get(HASHES)
    kind = Python if hasattr(os, "fork") and same_order else subprocess.Popen
    return kind(list(map(str, words)), **options)


def _become(
    words: list[str],
    streams: tuple[int, int, int],
    pass_fds: Collection[int],
    cwd: str | None,
    env: Mapping[str, str] | None,
) -> NoReturn:
    """Be a process that has just been forked, to its end."""
    status = 1
    try:
        gc.freeze()  # what the parent has open is closed once, by number
        gc.callbacks.clear()  # Hypothesis has one; a Ctrl-C that comes while it runs would be lost
        _take_streams(streams, pass_fds)
        _forget_pytest()
        if cwd is not None:
            os.chdir(cwd)
        if env is not None:
            os.environ.clear()
            os.environ.update(env)
        status = _status_of(words)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def _take_streams(streams: tuple[int, int, int], pass_fds: Collection[int]) -> None:
    """Have 0, 1 and 2 open, and those that are given, and no other file of the parent."""
    copies = [os.dup(given) if given != -1 else -1 for given in streams]
    for number, copy in enumerate(copies):
        if copy != -1:
            os.dup2(copy, number)
    kept = sorted({0, 1, 2, *pass_fds})
    for low, high in zip(kept, [*kept[1:], os.sysconf("SC_OPEN_MAX")], strict=True):
        os.closerange(low + 1, high)
    sys.stdin = open(0, encoding="locale", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="locale", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", 1, encoding="locale", errors="backslashreplace", closefd=False)  # noqa: SIM115


def _forget_pytest() -> None:
    """Have signals, warnings and hooks as they are when Python starts."""
    signal.set_wakeup_fd(-1)
    for number in signal.valid_signals():
        if callable(signal.getsignal(number)):
            begun = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
            signal.signal(number, begun)
    warnings.simplefilter("ignore")
    sys.unraisablehook, threading.excepthook = sys.__unraisablehook__, threading.__excepthook__


def _status_of(words: list[str]) -> int:
    """Run the code or the module, and return the exit status."""
    try:
        _run(words)
    except SystemExit as end:
        if isinstance(end.code, str):
            sys.stderr.write(f"{end.code}\n")
            return 1
        return end.code or 0
    finally:
        threading._shutdown()  # type: ignore[attr-defined]  # waits for threads as the end of Python does
        sys.stdout.flush()
        sys.stderr.flush()
    return 0


def _run(words: list[str]) -> None:
    start = next(number for number, word in enumerate(words) if word in ("-c", "-m"))
    kind, what, *arguments = words[start:]
    sys.argv[:] = [kind, *arguments]
    if "-P" not in words[:start]:
        sys.path.insert(0, "" if kind == "-c" else os.getcwd())
    if kind == "-m":
        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        main = sys.modules["__main__"] = types.ModuleType("__main__")
        exec(what, vars(main))
