"""Debugs a test of pytest: the racks on its benches, one after the other.

    pytest --scanrack-debug     prints a port and a key, and waits for a client at the first bench
    launch with `pytest`        the adapter runs pytest itself

The test is blocked while the client inspects it, and continues when the client does.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import TYPE_CHECKING

from scanrack.jobs.bench import Bench
from scanrack.jobs.record.settable_tags import settable_tags
from scanrack.ladder.debug import Debugger
from scanrack.ladder.python.online.fields import Fields
from scanrack.runtime.live import actions
from typing_extensions import override

from .adapter import Adapter
from .breakpoints import Hit
from .live import LiveRungs, LiveText, ScanDriver
from .plugin_name import DEBUGGER
from .protocol import DebugError

if TYPE_CHECKING:
    import pytest


class BenchRun:
    """A bench, as `live.ScanRun`."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.cpu, self.rack = bench, bench.cpu, bench.cpu.rack
        self.debugger = bench.logic if isinstance(bench.logic, Debugger) else None
        self.program = self

    @property
    def logic(self) -> Callable[..., None]:
        """The logic that the CPU calls."""
        logic: Callable[..., None] = self.bench.logic
        return logic

    @property
    def edits(self) -> int:
        """Number of edits."""
        return 0 if self.debugger is None else len(self.debugger.edits)

    @property
    def operated(self) -> Debugger | Fields | None:
        """The program's values that can be set and forced."""
        return settable_tags(self.bench.logic)


class InTest(ScanDriver):
    """A driver of a test, which runs its bench itself: blocks the scan loop while the client looks."""

    def __init__(self, adapter: Adapter, bench: Bench) -> None:
        run = BenchRun(bench)
        if run.debugger is not None:
            super().__init__(adapter, LiveRungs(run))
        elif bench.load is not None:
            load = bench.load
            super().__init__(adapter, LiveText(run, load, bench.spec))
        else:
            raise DebugError("this bench has a program without a file, so its lines can't be stepped through")
        self._run, self._stepping, self._pausing = run, False, False
        adapter.begin(self.subject, self)
        self.place_again()
        while not adapter.configured and not adapter.over:
            adapter.serve(None)
        adapter.running = True
        bench.cpu.add_listener(self)

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        adapter = self._adapter
        if adapter.over:
            return
        hits = self.look(scan, now_ns, flags)
        if adapter.wire.waiting:
            adapter.serve(0)
        stepped = self._stepping and (not isinstance(self.subject, LiveText) or self.subject.arrived)
        if hits or stepped or self._pausing:
            self._stand(scan, hits, stepped=stepped)

    def _stand(self, scan: int, hits: list[Hit], *, stepped: bool) -> None:
        """Stop in a scan until the client continues."""
        adapter = self._adapter
        self.subject.step(on=False)
        self._stepping = self._pausing = False
        if hits and not stepped:
            adapter.stop_at_hit(scan, hits)
        else:
            adapter.look_at(scan, "start" if stepped else "end")
            adapter.stopped("step" if stepped else "pause")
        while not adapter.running and not adapter.over:
            adapter.serve(None)

    @override
    def begin(self, *, stop: bool) -> None:
        if stop:
            self.step()

    @override
    def go(self) -> None:
        self._adapter.leave()
        self._adapter.running = True

    @override
    def pause(self) -> None:
        self._pausing = True

    @override
    def step(self) -> None:
        self._stepping = True
        self.subject.step(on=True)
        self.go()

    @override
    def give(self, order: actions.Action) -> None:
        desk = self._run.operated
        if desk is None or not isinstance(order, actions.Write | actions.Force | actions.Unforce):
            raise DebugError("the test gives the orders here: this one is not an order of a test")
        if isinstance(order, actions.Write):
            self._run.bench[order.tag] = order.value
        elif isinstance(order, actions.Force):
            desk.force(order.tag, order.value)
        else:
            desk.unforce(None if order.tag == actions.ALL else order.tag)

    @override
    def end(self) -> None:
        self._adapter.running = True  # the test continues


def run_tests(adapter: Adapter, words: str) -> None:
    """Run pytest, whose benches the client of an adapter debugs."""
    import pytest

    class TestPlugin:
        """Debugs the benches of this run."""

        def pytest_configure(self, config: pytest.Config) -> None:
            """Give pytest's plugin the adapter."""
            config.pluginmanager.register(lambda bench: InTest(adapter, bench), DEBUGGER)

    pytest.main([*shlex.split(words), "--scanrack-keep=never"], plugins=[TestPlugin()])
