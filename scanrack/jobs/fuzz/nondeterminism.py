"""Finds a program's sources of nondeterminism: chance, the clock, threads, or its process.

    call                                          source
    random.random and similar, without a seed     chance
    random.SystemRandom, secrets, os.urandom      chance
    time.*, datetime.now, today                   the clock
    threading.Thread.start                        threads
    os.environ, os.getpid, open, id, hash         state of the process

A profile function records the calls while the program is loaded and called. It covers only code that is
executed, and does not detect the effect of a set's order. It can explain a difference between two runs, but
can't rule out differences.
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
"""Source by the module of the called function."""

NAMES = {
    ("builtins", "id"): PROCESS,
    ("builtins", "hash"): PROCESS,
    ("posix", "urandom"): CHANCE,
    ("os", "urandom"): CHANCE,
}
"""Source by module and function. It overrides the module's source."""

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
"""Methods of a path that read the file system. Other methods use only its text."""


class NondeterminismSources:
    """The recorded sources of a program's nondeterminism.

    Attributes:
        seen: the first place that uses each source, such as "line.py:12".
    """

    def __init__(self) -> None:
        self.seen: dict[str, str] = {}
        self._is_seeded = False  # whether the program has set the seed of module `random`

    def __str__(self) -> str:
        return " and ".join(f"{source} ({place})" for source, place in sorted(self.seen.items()))

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record the calls of the user's code within the context."""
        previous_profiler = sys.getprofile()
        sys.setprofile(self._profile)
        try:
            yield
        finally:
            sys.setprofile(previous_profiler)

    def recording_bench(self, bench: TrialBench) -> TrialBench:
        """Return a bench that records the calls of its program while it is loaded and called."""

        def fresh_logic() -> ScanLogic:
            with self.recording():
                return _CallRecorder(bench.fresh_logic(), self)

        return replace(bench, fresh_logic=fresh_logic)

    def _profile(self, frame: FrameType, event: str, arg: Any) -> None:
        """Record the source of a call in the user's code; called by the interpreter."""
        if event == "c_call" and is_the_users(frame.f_code.co_filename):
            self._record(frame, self._builtin_source(arg))
        elif event == "call" and (caller := frame.f_back) and is_the_users(caller.f_code.co_filename):
            self._record(caller, self._function_source(frame))

    def _record(self, caller: FrameType, source: str | None) -> None:
        if source is not None:
            place = f"{Path(caller.f_code.co_filename).name}:{caller.f_lineno}"
            self.seen.setdefault(source, place)

    def _builtin_source(self, function: Callable[..., Any]) -> str | None:
        """Return the source that a C function uses, or None."""
        owner = getattr(function, "__self__", None)
        name = getattr(function, "__name__", "")
        if isinstance(owner, Random):
            return self._random_source(owner, name)
        if isinstance(owner, type) and owner.__module__ == "datetime":
            return CLOCK if name in ("now", "today", "utcnow") else None
        return _module_source(getattr(function, "__module__", None) or "", name)

    def _function_source(self, frame: FrameType) -> str | None:
        """Return the source that a Python function uses, or None."""
        module, name = str(frame.f_globals.get("__name__", "")), frame.f_code.co_name
        if module.startswith("pathlib."):  # a package since Python 3.13
            module = "pathlib"
        owner = frame.f_locals.get("self")
        if owner is os.environ:
            return PROCESS
        if isinstance(owner, Random):
            seed = frame.f_locals.get("x", frame.f_locals.get("a"))  # parameters of __init__ and seed
            return self._random_source(owner, name, seed)
        if module == "pathlib" and name not in PATH_READS:
            return None
        return _module_source(module, name)

    def _random_source(self, generator: Random, method: str, seed: object = None) -> str | None:
        """Return the source that a method of a random generator uses; None if the generator has a seed."""
        if method in ("seed", "__init__"):
            self._is_seeded = self._is_seeded or (method == "seed" and seed is not None)
            return CHANCE if seed is None else None
        is_unseeded = generator is MODULE_GENERATOR and not self._is_seeded
        return CHANCE if is_unseeded or type(generator).__name__ == "SystemRandom" else None


class _CallRecorder(LogicWrapper):
    """Records the sources of a logic's nondeterminism while it is called."""

    def __init__(self, logic: ScanLogic, sources: NondeterminismSources) -> None:
        super().__init__(logic)
        self._sources = sources

    def __call__(self, scan: Any) -> None:
        """Call the logic."""
        with self._sources.recording():
            self._logic(scan)


def _module_source(module: str, name: str) -> str | None:
    """Return the source that a function of a module uses, or None."""
    if (module, name) in NAMES:
        return NAMES[module, name]
    if name in DETERMINISTIC.get(module, ()) or name.startswith("<"):  # such as <genexpr>
        return None
    return MODULES.get(module)


MODULE_GENERATOR: Random = random.random.__self__  # type: ignore[attr-defined]
"""The generator that all users of the module `random` share."""
