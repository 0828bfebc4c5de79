"""Runs functions in new processes, without the modules that this one has loaded.

    this process                                 the new one
    modules to load first     -> standard input       (pickled)
    function, arguments       -> standard input       (pickled twice: reading it imports nothing)
    result or exception       <- standard output      (pickled)
    end of standard input     -> the process exits at once

The output of a function is discarded. A process ends with its parent.
"""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import closing
from importlib import import_module
from queue import SimpleQueue
from threading import Thread
from typing import Any, BinaryIO, ParamSpec, TypeVar

from ...trust.launcher import PIPE, launch

P = ParamSpec("P")
Result = TypeVar("Result")

HASH_SEEDS = ("20601", "3601")
"""Two hash seeds: at least one differs from the current one."""

LOADED_FIRST = ("wave", "sched", "colorsys", "zipfile", "random", "threading")
"""Modules that a process in a different environment loads first, in this order."""


def run_in_fresh_process(function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    """Run a function in a new process.

    Raises:
        BrokenExecutor: the process died.
        Exception: what the function raised.
    """
    return _once(Worker(), function, *args, **kwargs)


def run_in_other_environment(function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    """Run a function in a new process with a different hash seed and module load order.

    Raises:
        BrokenExecutor: the process died.
        Exception: what the function raised.
    """
    seed = next(seed for seed in HASH_SEEDS if seed != os.environ.get("PYTHONHASHSEED"))
    worker = Worker(LOADED_FIRST, os.environ | {"PYTHONHASHSEED": seed})
    return _once(worker, function, *args, **kwargs)


def _once(worker: Worker, function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    with closing(worker):
        result: Result = worker.run(function, args, kwargs)
        return result


class Worker:
    """A new process that runs one function after the other.

    Args:
        first: modules to load before all others, in this order.
        environment: environment variables of the process; None = the variables of this process.
    """

    def __init__(self, first: Sequence[str] = (), environment: dict[str, str] | None = None) -> None:
        self._process = launch(f"{__name__}:serve", stdin=PIPE, stdout=PIPE, environment=environment)
        self._send(first)

    def run(self, function: Callable[..., Any], args: Sequence[Any], kwargs: dict[str, Any]) -> Any:
        """Run a function in the process.

        Raises:
            BrokenExecutor: the process died.
            Exception: what the function raised.
        """
        assert self._process.stdout is not None
        self._send(pickle.dumps((function, args, kwargs)))
        try:
            has_result, value = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            raise BrokenExecutor("worker process died") from None
        if not has_result:
            raise value
        return value

    def kill(self) -> None:
        """Kill the process; a `run` in another thread raises."""
        self._process.kill()

    def close(self) -> None:
        """End the process and wait for it; no thread may be in `run`."""
        self.kill()
        self._process.communicate()

    def _send(self, what: object) -> None:
        """Write to the process; a dead process is detected later by its missing answer."""
        assert self._process.stdin is not None
        try:
            pickle.dump(what, self._process.stdin)
            self._process.stdin.flush()
        except OSError:  # BrokenPipeError except on Windows
            pass


def serve() -> None:
    """Serve the requests of the parent's `Worker`: the main function of the new process."""
    with os.fdopen(os.dup(0), "rb") as orders, os.fdopen(os.dup(1), "wb") as answers:
        with open(os.devnull, "r+b") as nowhere:
            os.dup2(nowhere.fileno(), 0)
            os.dup2(nowhere.fileno(), 1)
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a terminal sends Ctrl-C to all; only the parent prints
        for name in pickle.load(orders):
            import_module(name)
        waiting: SimpleQueue[bytes] = SimpleQueue()
        Thread(target=_read, args=(orders, waiting), daemon=True).start()
        while True:
            answers.write(_answer(waiting.get()))
            answers.flush()


def _read(orders: BinaryIO, waiting: SimpleQueue[bytes]) -> None:
    """Pass requests on; exit with the parent, even in the middle of a request."""
    try:
        while True:
            waiting.put(pickle.load(orders))
    except (EOFError, pickle.UnpicklingError):
        os._exit(1)


def _answer(order: bytes) -> bytes:
    """Run a request; return its result, or its exception for the parent to raise."""
    try:
        function, args, kwargs = pickle.loads(order)
        return pickle.dumps((True, function(*args, **kwargs)))
    except Exception as error:
        return pickle.dumps((False, error))
