"""Finds a program's sources of nondeterminism: chance, the clock, threads, its process.

    a call of                                     counts as
    random.random and similar, without a seed     chance
    random.SystemRandom, secrets, os.urandom      chance
    time.*, datetime.now, today                   the clock
    threading.Thread.start                        threads
    os.environ, os.getpid, open, id, hash         state of the process

A profile function sees the calls while the program is loaded and while it is called. It sees only executed
code, and not the order of a set. It can explain a difference between two runs, but can't rule one out.
"""

from __future__ import annotations

import os
import random
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from random import Random
from types import FrameType
from typing import Any

from scanrack.runtime.loop.faults import is_the_users
from scanrack.runtime.loop.scan import ScanLogic

from ..record.logic_wrapper import LogicWrapper
from .run import TrialBench

CHANCE, CLOCK, THREADS, PROCESS = "chance", "the clock", "threads", "state of the process"

MODULES = {
    "time": CLOCK,
    "secrets": CHANCE,
    "uuid": CHANCE,
    "threading": THREADS,
    "_thread": THREADS,
    "concurrent.futures.thread": THREADS,
    "multiprocessing.context": THREADS,
    "socket": PROCESS,
    "os": PROCESS,
    "posix": PROCESS,
    "io": PROCESS,
    "_io": PROCESS,
    "pathlib": PROCESS,
    "genericpath": PROCESS,
}
"""Sources by the module of the called function."""

NAMES = {
    ("builtins", "id"): PROCESS,
    ("builtins", "hash"): PROCESS,
    ("posix", "urandom"): CHANCE,
    ("os", "urandom"): CHANCE,
}
"""Sources of single functions; these override the module's source."""

DETERMINISTIC = {
    "time": {"strftime", "strptime", "mktime", "gmtime", "asctime"},
    "os": {"fspath", "_fspath"},
    "posix": {"fspath"},
    "threading": {"Lock", "RLock", "get_ident", "current_thread"},
    "_thread": {"allocate_lock", "lock", "RLock", "get_ident"},
    "io": {"StringIO", "BytesIO", "text_encoding"},
    "genericpath": {"commonprefix"},
    "_io": {"StringIO", "BytesIO", "text_encoding", "write", "flush"},
}
"""Deterministic functions of these modules."""

PATH_READS = {"open", "read_text", "read_bytes", "exists", "is_file", "is_dir", "stat", "iterdir", "glob"}
"""Methods of a path that read the file system; other methods use only its text."""


class NondeterminismSources:
    """The observed sources of a program's nondeterminism."""

    def __init__(self) -> None:
        self.seen: dict[str, str] = {}  # the first place that uses each source, such as "line.py:12"
        self._seeded = False

    def __str__(self) -> str:
        return " and ".join(f"{source} ({where})" for source, where in sorted(self.seen.items()))

    @contextmanager
    def noticing(self) -> Iterator[None]:
        """Observe the calls of the user's code within the context."""
        before = sys.getprofile()
        sys.setprofile(self._notice)
        try:
            yield
        finally:
            sys.setprofile(before)

    def watching(self, bench: TrialBench) -> TrialBench:
        """Return a bench that observes its program while it is loaded and called."""

        def fresh_logic() -> ScanLogic:
            with self.noticing():
                return _CallRecorder(bench.fresh_logic(), self)

        return replace(bench, fresh_logic=fresh_logic)

    def _notice(self, frame: FrameType, event: str, arg: Any) -> None:
        if event == "c_call" and is_the_users(frame.f_code.co_filename):
            self._note(frame, self._builtin(arg))
        elif event == "call" and (caller := frame.f_back) and is_the_users(caller.f_code.co_filename):
            self._note(caller, self._function(frame))

    def _note(self, frame: FrameType, what: str | None) -> None:
        if what is not None:
            where = f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"
            self.seen.setdefault(what, where)

    def _builtin(self, function: Callable[..., Any]) -> str | None:
        """Return the source that a C function uses, or None."""
        owner = getattr(function, "__self__", None)
        name = getattr(function, "__name__", "")
        if isinstance(owner, Random):
            return self._random(owner, name)
        if isinstance(owner, type) and owner.__module__ == "datetime":
            return CLOCK if name in ("now", "today", "utcnow") else None
        return _of_module(getattr(function, "__module__", None) or "", name)

    def _function(self, frame: FrameType) -> str | None:
        """Return the source that a Python function uses, or None."""
        module, name = str(frame.f_globals.get("__name__", "")), frame.f_code.co_name
        if module.startswith("pathlib."):  # a package since Python 3.13
            module = "pathlib"
        owner = frame.f_locals.get("self")
        if owner is os.environ:
            return PROCESS
        if isinstance(owner, Random):
            return self._random(owner, name, given=frame.f_locals.get("x", frame.f_locals.get("a")))
        if module == "pathlib" and name not in PATH_READS:
            return None
        return _of_module(module, name)

    def _random(self, owner: Random, name: str, given: object = None) -> str | None:
        """Return the source of a random generator's call; None if it has its own seed."""
        if name in ("seed", "__init__"):
            self._seeded = self._seeded or (name == "seed" and given is not None)
            return CHANCE if given is None else None
        shared = owner is MODULE_GENERATOR and not self._seeded
        return CHANCE if shared or type(owner).__name__ == "SystemRandom" else None


class _CallRecorder(LogicWrapper):
    """A logic whose calls are observed."""

    def __init__(self, logic: ScanLogic, uses: NondeterminismSources) -> None:
        super().__init__(logic)
        self._uses = uses

    def __call__(self, scan: Any) -> None:
        """Call the logic."""
        with self._uses.noticing():
            self._logic(scan)


def _of_module(module: str, name: str) -> str | None:
    if (module, name) in NAMES:
        return NAMES[module, name]
    return None if name in DETERMINISTIC.get(module, ()) or name.startswith("<") else MODULES.get(module)


MODULE_GENERATOR: Random = random.random.__self__  # type: ignore[attr-defined]
"""The generator that all users of module `random` share."""
