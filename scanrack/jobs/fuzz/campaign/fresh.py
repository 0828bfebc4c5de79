"""Runs functions in new processes that have not loaded this process's modules.

    this process                  the new process
    modules to load first     ->  standard input     (pickled)
    function and arguments    ->  standard input     (pickled twice: the reading thread imports nothing)
    result or exception       <-  standard output    (pickled)
    end of standard input     ->  exits at once

The printed output of a function is discarded. The process exits when its parent exits.
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
"""Two hash seeds. At least one differs from the current seed."""

LOADED_FIRST = ("wave", "sched", "colorsys", "zipfile", "random", "threading")
"""Modules that a process with a different environment loads first, in this order."""


def run_in_fresh_process(function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    """Run a function in a new process.

    Raises:
        BrokenExecutor: the process died.
        Exception: the function raised it.
    """
    return _run_once(Worker(), function, *args, **kwargs)


def run_in_other_environment(function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    """Run a function in a new process with a different hash seed and module load order.

    Raises:
        BrokenExecutor: the process died.
        Exception: the function raised it.
    """
    seed = next(seed for seed in HASH_SEEDS if seed != os.environ.get("PYTHONHASHSEED"))
    worker = Worker(LOADED_FIRST, os.environ | {"PYTHONHASHSEED": seed})
    return _run_once(worker, function, *args, **kwargs)


def _run_once(worker: Worker, function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    with closing(worker):
        result: Result = worker.run(function, args, kwargs)
        return result


class Worker:
    """A new process that runs functions, one after another.

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
            Exception: the function raised it.
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
        """Kill the process. A `run` in another thread raises BrokenExecutor."""
        self._process.kill()

    def close(self) -> None:
        """Kill the process and wait for it to exit. No thread may be in `run`."""
        self.kill()
        self._process.communicate()

    def _send(self, content: object) -> None:
        """Send an object to the process. If the process is dead, `run` notices the missing response."""
        assert self._process.stdin is not None
        try:
            pickle.dump(content, self._process.stdin)
            self._process.stdin.flush()
        except OSError:  # BrokenPipeError except on Windows
            pass


def serve() -> None:
    """Serve the requests of the parent's `Worker`. This is the main function of the new process."""
    with os.fdopen(os.dup(0), "rb") as requests, os.fdopen(os.dup(1), "wb") as responses:
        with open(os.devnull, "r+b") as null_device:
            os.dup2(null_device.fileno(), 0)
            os.dup2(null_device.fileno(), 1)
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C reaches all processes; only the parent prints
        for name in pickle.load(requests):
            import_module(name)
        queue: SimpleQueue[bytes] = SimpleQueue()
        Thread(target=_queue_requests, args=(requests, queue), daemon=True).start()
        while True:
            responses.write(_run_request(queue.get()))
            responses.flush()


def _queue_requests(requests: BinaryIO, queue: SimpleQueue[bytes]) -> None:
    """Put requests into a queue. Exit when the parent exits, even while a request is running."""
    try:
        while True:
            queue.put(pickle.load(requests))
    except (EOFError, pickle.UnpicklingError):
        os._exit(1)


def _run_request(request: bytes) -> bytes:
    """Run a request; return its result, or its exception for the parent to raise."""
    try:
        function, args, kwargs = pickle.loads(request)
        return pickle.dumps((True, function(*args, **kwargs)))
    except Exception as error:
        return pickle.dumps((False, error))
