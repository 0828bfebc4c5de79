"""Run tests in processes that are forked when all tests are collected: each module is imported once.

    collected ──fork──> process 0   takes a folder or file of tests, runs it, takes the next
               └─fork─> process 1   ...
               the parent prints what they report

Where Python can't fork, and with `--processes 1`, pytest runs the tests itself.
"""

from __future__ import annotations

import mmap
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, groupby, pairwise
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from types import SimpleNamespace
from typing import Any

import pytest

Group = list[pytest.Item]


class Processes:
    """A plugin of pytest.

    Args:
        count: number of processes.
        together: what the tests of a process have in common; they must stand next to each other.
        result: called in each process when its tests have run.
        results: takes what `result` has returned in each.
    """

    def __init__(
        self,
        count: int,
        together: Callable[[pytest.Item], object],
        result: Callable[[], Any],
        results: Callable[[Any], None],
    ) -> None:
        self._count, self._together = count, together
        self._result, self._results = result, results

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        """Fork and report; None leaves it to pytest to run the tests."""
        config = session.config
        unfit = config.option.collectonly or config.option.usepdb or session.testsfailed
        if self._count == 1 or unfit or not hasattr(os, "fork"):
            return None
        groups = [list(group) for _, group in groupby(session.items, self._together)]
        workers = self._started(session, groups)
        try:
            _report(session, workers)
        finally:
            for worker in workers:
                worker.end()
        for worker in workers:
            self._results(worker.result)
        return True

    def _started(self, session: pytest.Session, groups: Sequence[Group]) -> list[Worker]:
        """Fork the processes; a pipe has the numbers of the groups that none of them has taken."""
        numbers, writer = os.pipe()
        os.write(writer, b"".join(number.to_bytes(2) for number in range(len(groups))))
        os.close(writer)
        stop = mmap.mmap(-1, 1)
        folder = session.config._tmp_path_factory  # type: ignore[attr-defined]  # each process gets its own
        folder.getbasetemp()
        workers: list[Worker] = []
        for number in range(min(self._count, len(groups))):
            ours, theirs = Pipe(duplex=False)
            if not (pid := fork()):
                for other in workers:
                    other.pipe.close()
                folder._basetemp = folder.mktemp(f"process{number}", numbered=False)
                _become_worker(session, _taken(numbers, groups, stop), theirs, self._result)
            theirs.close()
            workers.append(Worker(number, pid, ours, stop))
        os.close(numbers)
        return workers


class Worker:
    """A process that runs tests, as its parent sees it.

    Attributes:
        running: id of the test that runs; None between tests.
        result: what it sends at its end.
    """

    def __init__(self, number: int, pid: int, pipe: Connection, stop: mmap.mmap) -> None:
        self.node = SimpleNamespace(gateway=SimpleNamespace(id=number), _workerinfocache=f"process {number}")
        """Tells pytest's terminal that reports come from several processes, as those of pytest-xdist do."""
        self.pipe, self.running, self.result = pipe, "", None
        self._pid, self._stop = pid, stop

    def end(self) -> None:
        """Let it end after its present test."""
        self._stop[0] = 1
        self.pipe.close()
        os.waitpid(self._pid, 0)


def _report(session: pytest.Session, workers: Sequence[Worker]) -> None:
    """Hand on what the processes report, until they have ended or pytest has had enough."""
    open_pipes = {worker.pipe: worker for worker in workers}
    while open_pipes:
        for pipe in wait(list(open_pipes)):
            worker = open_pipes[pipe]  # type: ignore[index]  # what waits are the keys
            try:
                kind, value = worker.pipe.recv()
            except EOFError:
                pytest.exit(f"a process has ended in {worker.running}", pytest.ExitCode.TESTS_FAILED)
            if kind == "result":
                worker.result = value
                del open_pipes[worker.pipe]
            else:
                _hand_on(session, worker, kind, value)
            if session.shouldfail:  # after each report: one failure is enough, however many have come
                raise session.Failed(session.shouldfail)
            if session.shouldstop:
                raise session.Interrupted(session.shouldstop)


def _hand_on(session: pytest.Session, worker: Worker, kind: str, value: Any) -> None:
    hook = session.config.hook
    if kind == "start":
        worker.running = value[0]
    elif kind == "finish":
        hook.pytest_runtest_logfinish(nodeid=value[0], location=value[1])
    elif kind == "broken":
        pytest.exit(value, pytest.ExitCode.TESTS_FAILED)
    else:
        report = hook.pytest_report_from_serializable(config=session.config, data=value)
        report.node = worker.node
        hook.pytest_runtest_logreport(report=report)


def fork() -> int:
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # threads of libraries wait for work, no lock held
        return os.fork()


def _taken(numbers: int, groups: Sequence[Group], stop: mmap.mmap) -> Iterator[pytest.Item]:
    """Give the tests of one group after the other, until none is left or the parent says stop."""
    while taken := os.read(numbers, 2):
        for item in groups[int.from_bytes(taken)]:
            if stop[0]:
                return
            yield item


def _become_worker(
    session: pytest.Session, items: Iterator[pytest.Item], pipe: Connection, result: Callable[[], Any]
) -> None:
    """Run tests in a process that has just been forked, and end it."""
    status = 1
    try:
        manager = session.config.pluginmanager
        capture = manager.getplugin("capturemanager")
        capture.stop_global_capturing()  # its files are those of the parent
        capture.start_global_capturing()
        manager.unregister(name="terminalreporter")
        manager.register(_Sender(session.config, pipe))
        _run(session, items)
        pipe.send(("result", result()))
        status = 0
    except BrokenPipeError:
        pass
    except BaseException:
        pipe.send(("broken", traceback.format_exc()))
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _run(session: pytest.Session, items: Iterator[pytest.Item]) -> None:
    try:
        for item, following in pairwise(chain(items, [None])):
            assert item is not None
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
    finally:
        session._setupstate.teardown_exact(None)


class _Sender:
    """Sends reports to the parent."""

    def __init__(self, config: pytest.Config, pipe: Connection) -> None:
        self._config, self._pipe = config, pipe

    def pytest_runtest_logstart(self, nodeid: str, location: object) -> None:
        self._pipe.send(("start", (nodeid, location)))

    def pytest_runtest_logfinish(self, nodeid: str, location: object) -> None:
        self._pipe.send(("finish", (nodeid, location)))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        self._pipe.send(("report", data))
