"""Runs a function in a process of its own, without the modules that this one has loaded.

    this process                     the new one
    sys.path, function, arguments -> standard input     (pickled)
    result or exception           <- standard output    (pickled)
    end of standard input         -> it ends at once

What the function prints goes nowhere. The process ends when its parent does.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from importlib import import_module
from threading import Thread
from typing import Any, BinaryIO, ParamSpec, TypeVar

P = ParamSpec("P")
Result = TypeVar("Result")

BOOT = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    f"from {__name__} import serve; serve(sys.stdin.buffer)"
)
"""What the new process runs first."""


def in_fresh_process(
    function: Callable[P, Result],
    *args: P.args,
    **kwargs: P.kwargs,
) -> Result:
    """Run a function in a new process.

    Raises:
        BrokenExecutor: the process died.
        Exception: what the function raised.
    """
    return _done(function, args, kwargs, before=(), environment=os.environ.copy())


def in_other_surroundings(function: Callable[P, Result], *args: P.args, **kwargs: P.kwargs) -> Result:
    """Run a function in a new process with another hash seed and another order of modules.

    Raises:
        BrokenExecutor: the process died.
        Exception: what the function raised.
    """
    seed = next(seed for seed in HASH_SEEDS if seed != os.environ.get("PYTHONHASHSEED"))
    environment = os.environ | {"PYTHONHASHSEED": seed}
    return _done(function, args, kwargs, before=LOADED_FIRST, environment=environment)


HASH_SEEDS = ("20601", "3601")
"""Two of them, so that there is always a different one."""

LOADED_FIRST = ("wave", "sched", "colorsys", "zipfile", "random", "threading")
"""Modules that the other process loads before all others, in this order."""


def _done(
    function: Callable[..., Result],
    args: Sequence[Any],
    kwargs: dict[str, Any],
    *,
    before: Sequence[str],
    environment: dict[str, str],
) -> Result:
    with subprocess.Popen(
        [sys.executable, "-c", BOOT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            _send(process.stdin, list(sys.path), before, (function, args, kwargs))
            answer = process.stdout.read()
        finally:
            process.kill()
    if not answer:
        raise BrokenExecutor("the process that was to do it has died")
    done, value = pickle.loads(answer)
    if not done:
        raise value
    result: Result = value
    return result


def _send(pipe: BinaryIO | Any, *what: object) -> None:
    """Write to a process; a dead one shows by its missing answer."""
    try:
        for each in what:
            pickle.dump(each, pipe)
        pipe.flush()
    except BrokenPipeError:
        pass


def serve(orders: BinaryIO) -> None:
    """Do what `_done` of the parent asks for; this is the new process."""
    answers = os.fdopen(os.dup(1), "wb")
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a terminal sends Ctrl-C to all; only the parent speaks
    for name in pickle.load(orders):
        import_module(name)
    function, args, kwargs = pickle.load(orders)
    Thread(target=_end_with_the_parent, args=(orders,), daemon=True).start()
    with answers:
        pickle.dump(_outcome(function, args, kwargs), answers)


def _outcome(function: Callable[..., Any], args: Sequence[Any], kwargs: dict[str, Any]) -> tuple[bool, Any]:
    try:
        return True, function(*args, **kwargs)
    except Exception as error:  # it is raised in the parent
        return False, error


def _end_with_the_parent(orders: BinaryIO) -> None:
    orders.read()
    os._exit(1)
