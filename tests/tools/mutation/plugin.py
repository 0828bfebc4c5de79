"""The pytest plugin inside a trial: which tests run in which order, for how long, and what they touch.

The task is a JSON file whose path is in the environment:

    root      the private copy; the project must be imported from there
    order     ids of the tests to run, in this order; null for all of them
    seconds   processor time that each may take, by id
    trace     files whose executed lines are noted, and with them the rules that fire, test by test
    report    where the outcome goes
"""

from __future__ import annotations

import importlib.util
import json
import os
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import hypothesis
import pytest

TASK = "SCANRACK_MUTATION_TASK"
NOT_THE_COPY = 70
"""Exit status: the project was not imported from the copy."""
MEMORY_BYTES = 3 << 30
UNLIMITED_S = 3_600.0


def pytest_configure(config: pytest.Config) -> None:
    task = json.loads(Path(os.environ[TASK]).read_text(encoding="utf-8"))
    spec = importlib.util.find_spec("scanrack.runtime.modules.amci3601.command_layer")
    if spec is None or not str(spec.origin).startswith(task["root"]):
        pytest.exit("the project is not imported from the private copy", NOT_THE_COPY)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    config.pluginmanager.register(Trial(task))


class Trial:
    """Runs the tests of a task and reports on them."""

    def __init__(self, task: dict[str, Any]) -> None:
        self.task = task
        self.report: dict[str, Any] = {"failed": [], "passed": []}
        self.report |= {"seconds": {}, "lines": {}, "rules": {}, "fired": {}}
        self._traced: dict[str, str] = task["trace"]  # the project's paths by those of the copy
        self._hits: dict[str, set[int]] = {}
        self._fired: set[str] = set()
        if self._traced:
            from scanrack.runtime.modules.amci3601.latches import Latches

            Latches.fire = self._noting(Latches.fire)  # type: ignore[method-assign]
        signal.signal(signal.SIGPROF, _time_over)

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        phases = (
            hypothesis.Phase.explicit,
            hypothesis.Phase.generate,
        )  # no need to know the smallest example
        hypothesis.settings.register_profile("mutants", hypothesis.settings(), phases=phases)
        hypothesis.settings.load_profile("mutants")
        if self.task["order"] is not None:
            place = {node: index for index, node in enumerate(self.task["order"])}
            items[:] = sorted((item for item in items if item.nodeid in place), key=lambda i: place[i.nodeid])

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.report["rules"][item.nodeid] = [
            rule for mark in item.iter_markers("rules") for rule in mark.args
        ]
        self._hits, self._fired = {}, set()
        start = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, self.task["seconds"].get(item.nodeid, UNLIMITED_S))
        if self._traced:
            sys.settrace(self._on_call)
        yield
        sys.settrace(None)
        signal.setitimer(signal.ITIMER_PROF, 0)
        self.report["fired"][item.nodeid] = sorted(self._fired)
        self.report["seconds"][item.nodeid] = round(time.process_time() - start, 4)
        self.report["lines"][item.nodeid] = {path: sorted(lines) for path, lines in self._hits.items()}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.report["failed"].append(report.nodeid)
        elif report.when == "call" and report.passed:
            self.report["passed"].append(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        Path(self.task["report"]).write_text(json.dumps(self.report), encoding="utf-8")

    def _noting(self, fire: Callable[..., int]) -> Callable[..., int]:
        """Return `Latches.fire` that also notes which rule it was called with."""

        def noting(latches: object, now_ns: int, rule_id: str, **how: Any) -> int:
            self._fired.add(rule_id)
            return fire(latches, now_ns, rule_id, **how)

        return noting

    def _on_call(self, frame: FrameType, event: str, arg: object) -> Any:
        path = self._traced.get(frame.f_code.co_filename)
        if path is None:
            return None
        add = self._hits.setdefault(path, set()).add

        def on_line(frame: FrameType, event: str, arg: object) -> Any:
            add(frame.f_lineno)
            return on_line

        return on_line


def _time_over(number: int, frame: FrameType | None) -> None:
    pytest.fail("took too long")
