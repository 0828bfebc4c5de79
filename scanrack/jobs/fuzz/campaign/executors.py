"""Executors for the tasks of a campaign: this process, a pool of processes, or a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Executor, Future
from contextlib import suppress
from queue import SimpleQueue
from threading import Event, Thread
from typing import Any

from scanrack.io_images.installing import how_to_install
from scanrack.runtime.live.quiet import quiet
from scanrack.runtime.loop.pace import wall_ns

from .fresh import Worker
from .state import CampaignError


def _settle(future: Future[Any], call: Callable[..., Any], /, *args: Any, **kwargs: Any) -> None:
    """Call a function and store its result or exception in a future."""
    try:
        future.set_result(call(*args, **kwargs))
    except Exception as error:
        future.set_exception(error)


class InlineExecutor(Executor):
    """Runs every task in this process when it is submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a task and return its completed future."""
        future: Future[Any] = Future()
        _settle(future, fn, *args, **kwargs)
        return future


class Processes(Executor):
    """Runs tasks in processes. Kills the processes at shutdown."""

    def __init__(self, jobs: int) -> None:
        """Start the processes and, for each of them, a thread that sends it queued tasks."""
        self._queue: SimpleQueue[tuple[Future[Any], Call] | None] = SimpleQueue()  # None = stop a thread
        self._workers = [Worker() for _ in range(jobs)]
        self._threads = [Thread(target=self._serve, args=(worker,), daemon=True) for worker in self._workers]
        for thread in self._threads:
            thread.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Queue a task for a process."""
        future: Future[Any] = Future()
        self._queue.put((future, (fn, args, kwargs)))
        return future

    def _serve(self, worker: Worker) -> None:
        """Send tasks to a process, one after another. If the process dies, all tasks fail."""
        while (task := self._queue.get()) is not None:
            future, call = task
            _settle(future, worker.run, *call)
        worker.close()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Kill the processes. Tasks without a result fail."""
        for worker in self._workers:
            worker.kill()
            self._queue.put(None)
        if wait:
            for thread in self._threads:
                thread.join()


Call = tuple[Callable[..., Any], Sequence[Any], dict[str, Any]]
"""A function with its positional and keyword arguments."""


class OnCluster(Executor):
    """Runs tasks on a Dask cluster. Disconnects at shutdown."""

    def __init__(self, client: Any, address: str, say: Say) -> None:
        """Create an executor on the cluster, and a thread that reports when the cluster has no workers."""
        self._client = client
        self._address = address
        self._executor: Executor = client.get_executor(pure=False)
        self._is_shut_down = Event()
        self._is_connection_lost = False
        Thread(target=self._look_for_workers, args=(say,), daemon=True).start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a task to a worker.

        Raises:
            CampaignError: the connection is lost. The future can also have this exception.
        """
        result_future: Future[Any] = Future()
        try:
            dask_future = self._executor.submit(fn, *args, **kwargs)
        except CONNECTION_LOST as error:
            raise self._connection_lost() from error
        dask_future.add_done_callback(lambda _done: self._copy_result(dask_future, result_future))
        return result_future

    @property
    def threads(self) -> int:
        """Number of tasks that the cluster can run at once, at least one."""
        with suppress(*CONNECTION_LOST):
            threads: int = sum(self._client.nthreads().values())
            return max(1, threads)
        return 1  # the next task reports the lost connection

    def _copy_result(self, dask_future: Future[Any], result_future: Future[Any]) -> None:
        """Copy the cluster's result or error. The cluster cancels lost tasks."""
        error = self._connection_lost() if dask_future.cancelled() else dask_future.exception()
        if isinstance(error, CONNECTION_LOST):
            error = self._connection_lost()
        if error is None:
            result_future.set_result(dask_future.result())
        else:
            result_future.set_exception(error)

    def _connection_lost(self) -> CampaignError:
        """Record that the connection is lost; return the error."""
        self._is_connection_lost = True
        return CampaignError(
            f"lost the connection to the Dask scheduler at {self._address}; the results so far are saved: "
            "start a scheduler, and run the same command to continue"
        )

    def _look_for_workers(self, say: Say) -> None:
        """Print a message when the cluster has had no worker for some time."""
        last_worker_ns, is_reported = wall_ns(), False
        while not self._is_shut_down.wait(0.5):
            try:
                workers = self._client.nthreads()
            except CONNECTION_LOST:
                return  # the tasks report the lost connection
            if workers:
                last_worker_ns, is_reported = wall_ns(), False
            elif not is_reported and wall_ns() - last_worker_ns >= NO_WORKER_NS:
                is_reported = True
                say(
                    f"the Dask scheduler at {self._address} has had no worker for {NO_WORKER_NS // 10**9} s; "
                    f"to start one: dask worker {self._address}"
                )

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Close the connection. The cluster continues to run."""
        self._is_shut_down.set()
        if self._is_connection_lost:
            with suppress(*CONNECTION_LOST):
                self._client.close(timeout=1)
            return
        self._executor.shutdown(wait=wait)
        self._client.close()


Say = Callable[[str], object]
"""Prints a message."""

NO_WORKER_NS = 5_000_000_000
"""Time without a worker in the cluster before a message is printed, ns."""

CONNECTION_LOST = (OSError, AssertionError, RuntimeError, CancelledError)
"""Errors that Dask raises after the connection is lost."""


def executor_of(jobs: int, dask: str | None, say: Say = lambda _text: None) -> Callable[[], Executor]:
    """Return a function that creates the executor.

    Args:
        jobs: number of processes; 1 = this process.
        dask: address of the cluster's scheduler; None = no cluster.

    Raises:
        ValueError: raised by the returned function if Dask is missing or no scheduler answers.
    """
    if dask is not None:
        return lambda: _connect(dask, say)
    return InlineExecutor if jobs == 1 else lambda: Processes(jobs)


def _connect(address: str, say: Say) -> Executor:
    """Return an executor on a Dask cluster; raise ValueError if Dask is missing or no scheduler answers."""
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise ValueError(f"a cluster needs dask: {how_to_install('cluster')}") from None
    quiet("distributed")
    try:
        client: Any = Client(address, timeout=10)  # type: ignore[no-untyped-call, unused-ignore]
    except OSError as error:
        raise ValueError(f"no Dask scheduler answers at {address}: {error}") from error
    return OnCluster(client, address, say)
