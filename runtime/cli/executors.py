"""Who does the tasks of a campaign: this process, a pool of processes, or a Dask cluster."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import active_children, get_context, parent_process
from threading import Thread
from typing import Any


class Here(Executor):
    """Does every task at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it, and return what came out of it."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # it is raised where the result is asked for
            future.set_exception(error)
        return future


class Processes(Executor):
    """Has tasks done by processes, and ends them with what they do when it is shut down.

    Args:
        jobs: how many at a time.
    """

    def __init__(self, jobs: int) -> None:
        self._others = set(active_children())
        self._pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_end_in_time)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send it to a process."""
        return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; with `cancel_futures` in the middle of their work."""
        if cancel_futures:
            for process in set(active_children()) - self._others:
                process.terminate()
        self._pool.shutdown(wait=wait, cancel_futures=cancel_futures)


def _end_in_time() -> None:
    """Let a worker end without a word on Ctrl-C, which a terminal sends to all, and when its parent dies."""
    signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(130))
    Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class OnCluster(Executor):
    """Has tasks done by a Dask cluster, and leaves it when it is shut down.

    Args:
        client: a `distributed.Client`.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._executor: Executor = client.get_executor(pure=False)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send it to a worker."""
        return self._executor.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Close the connection; the cluster goes on."""
        self._executor.shutdown(wait=wait)
        self._client.close()


def executor_of(jobs: int, dask: str | None) -> Callable[[], Executor]:
    """Return what makes the executor: this process, a pool of processes, or a Dask cluster.

    Args:
        jobs: how many tasks at a time.
        dask: address of the cluster's scheduler; None = there is no cluster.

    Raises:
        ValueError: when the executor is made: the cluster's library is missing, or nothing answers.
    """
    if dask is not None:
        return lambda: _dask(dask)
    return Here if jobs == 1 else lambda: Processes(jobs)


def _dask(address: str) -> Executor:
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise ValueError("a cluster needs dask: pip install 'scanrack[cluster]'") from None
    try:
        client: Any = Client(address, timeout=10)  # type: ignore[no-untyped-call, unused-ignore]
    except OSError as error:
        raise ValueError(f"no Dask scheduler answers at {address}: {error}") from error
    return OnCluster(client)
