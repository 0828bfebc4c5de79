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
    """Set the result of a call, or its exception, which is raised where the result is read."""
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
    """Runs tasks in processes, and kills the processes at shutdown."""

    def __init__(self, jobs: int) -> None:
        self._waiting: SimpleQueue[tuple[Future[Any], Call] | None] = SimpleQueue()
        self._workers = [Worker() for _ in range(jobs)]
        self._threads = [Thread(target=self._serve, args=(worker,), daemon=True) for worker in self._workers]
        for thread in self._threads:
            thread.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Queue a task for a process."""
        future: Future[Any] = Future()
        self._waiting.put((future, (fn, args, kwargs)))
        return future

    def _serve(self, worker: Worker) -> None:
        """Send tasks to a process, one after the other; if it dies, all tasks fail."""
        while (task := self._waiting.get()) is not None:
            future, call = task
            _settle(future, worker.run, *call)
        worker.close()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; tasks without a result fail."""
        for worker in self._workers:
            worker.kill()
            self._waiting.put(None)
        if wait:
            for thread in self._threads:
                thread.join()


Call = tuple[Callable[..., Any], Sequence[Any], dict[str, Any]]


class OnCluster(Executor):
    """Runs tasks on a Dask cluster, and leaves the cluster at shutdown."""

    def __init__(self, client: Any, address: str, say: Say) -> None:
        self._client = client
        self._address = address
        self._executor: Executor = client.get_executor(pure=False)
        self._over = Event()
        self._lost = False
        Thread(target=self._look_for_workers, args=(say,), daemon=True).start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a task to a worker.

        Raises:
            CampaignError: the scheduler is gone. The future may also have this as its exception.
        """
        answer: Future[Any] = Future()
        try:
            submitted = self._executor.submit(fn, *args, **kwargs)
        except CONNECTION_LOST as error:
            raise self._connection_lost() from error
        submitted.add_done_callback(lambda _done: self._pass_on(submitted, answer))
        return answer

    @property
    def threads(self) -> int:
        """Number of tasks that the cluster runs at a time, at least one."""
        with suppress(*CONNECTION_LOST):
            threads: int = sum(self._client.nthreads().values())
            return max(1, threads)
        return 1  # the next task reports the lost connection

    def _pass_on(self, submitted: Future[Any], answer: Future[Any]) -> None:
        """Copy the cluster's result; the cluster cancels tasks that it has lost."""
        error = self._connection_lost() if submitted.cancelled() else submitted.exception()
        if isinstance(error, CONNECTION_LOST):
            error = self._connection_lost()
        if error is None:
            answer.set_result(submitted.result())
        else:
            answer.set_exception(error)

    def _connection_lost(self) -> CampaignError:
        self._lost = True
        return CampaignError(
            f"the Dask scheduler at {self._address} has gone; what is known is kept: the same command, "
            "with a scheduler that runs, continues from here"
        )

    def _look_for_workers(self, say: Say) -> None:
        """Print a message when the cluster has had no worker for some time."""
        since_ns, reported = wall_ns(), False
        while not self._over.wait(0.5):
            try:
                workers = self._client.nthreads()
            except CONNECTION_LOST:
                return  # the tasks report the lost connection
            if workers:
                since_ns, reported = wall_ns(), False
            elif not reported and wall_ns() - since_ns >= NO_WORKER_NS:
                reported = True
                say(
                    f"the Dask scheduler at {self._address} has had no worker for {NO_WORKER_NS // 10**9} s; "
                    f"the search waits for one: dask worker {self._address}"
                )

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Close the connection; the cluster continues."""
        self._over.set()
        if self._lost:
            with suppress(*CONNECTION_LOST):  # the connection is gone already
                self._client.close(timeout=1)
            return
        self._executor.shutdown(wait=wait)
        self._client.close()


Say = Callable[[str], object]

NO_WORKER_NS = 5_000_000_000
"""Time without any worker in the cluster before a message is printed, ns."""

CONNECTION_LOST = (OSError, AssertionError, RuntimeError, CancelledError)
"""Errors that Dask raises after a broken connection."""


def executor_of(jobs: int, dask: str | None, say: Say = lambda _text: None) -> Callable[[], Executor]:
    """Return a function that makes the executor: this process, a pool of processes, or a Dask cluster.

    Args:
        dask: address of the cluster's scheduler; None = no cluster.

    Raises:
        ValueError: by the returned function if Dask is missing or no scheduler answers.
    """
    if dask is not None:
        return lambda: _dask(dask, say)
    return InlineExecutor if jobs == 1 else lambda: Processes(jobs)


def _dask(address: str, say: Say) -> Executor:
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
