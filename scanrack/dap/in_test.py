"""Debugging of the racks on the benches of a pytest test, one after the other.

    pytest --scanrack-debug     prints a port and a key, and waits for a client at the first bench
    launch with `pytest`        the adapter runs pytest itself

The test waits while it is stopped by the client.
"""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

from scanrack.jobs.bench import Bench
from scanrack.jobs.record.settable_tags import settable_tags
from scanrack.ladder.debug import Debugger
from scanrack.ladder.python.online.fields import Fields
from scanrack.runtime.live import actions
from scanrack.runtime.loop.scan import ScanLogic
from typing_extensions import override

from .adapter import Adapter
from .breakpoints import Hit
from .live import LiveRungs, LiveText, ScanDriver
from .plugin_name import DEBUGGER
from .protocol import DebugError

if TYPE_CHECKING:
    import pytest


class BenchProgram:
    """The program of a bench, with the interface of `live.Program`."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.debugger = bench.logic if isinstance(bench.logic, Debugger) else None

    @property
    def logic(self) -> ScanLogic:
        """The logic that the CPU calls."""
        logic: ScanLogic = self._bench.logic
        return logic

    @property
    def edits(self) -> int:
        """Number of edits."""
        return 0 if self.debugger is None else len(self.debugger.edits)

    @property
    def operated(self) -> Debugger | Fields | None:
        """The program's values that can be set and forced."""
        return settable_tags(self.logic)


class InTest(ScanDriver):
    """The driver for a test; the test runs its own bench, and waits within a scan while stopped."""

    def __init__(self, adapter: Adapter, bench: Bench) -> None:
        """Begin to debug a bench, and wait until the client has set its breakpoints."""
        program = BenchProgram(bench)
        if program.debugger is not None:
            super().__init__(adapter, LiveRungs(bench.cpu, program))
        elif bench.load is not None:
            super().__init__(adapter, LiveText(bench.cpu, program, bench.load, bench.spec))
        else:
            raise DebugError("the program of this bench has no file, so its lines can't be stepped through")
        self._bench, self._program = bench, program
        self._stepping = self._pausing = False  # whether the client has requested a step, or a pause
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
        # with rungs, a step ends with the scan; otherwise, when a line has run
        stepped = self._stepping and (not isinstance(self.subject, LiveText) or self.subject.arrived)
        if hits or stepped or self._pausing:
            self._stop_in(scan, hits, stepped=stepped)

    def _stop_in(self, scan: int, hits: list[Hit], *, stepped: bool) -> None:
        """Stop in a scan, and wait until the client continues."""
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
    def apply(self, action: actions.Action) -> None:
        """Set, force or release a tag; raise DebugError for any other action."""
        tags = self._program.operated
        if tags is None or not isinstance(action, actions.Write | actions.Force | actions.Unforce):
            raise DebugError("in a test, tags can be set, forced and released; the test does everything else")
        if isinstance(action, actions.Write):
            self._bench[action.tag] = action.value
        elif isinstance(action, actions.Force):
            tags.force(action.tag, action.value)
        else:
            tags.unforce(None if action.tag == actions.ALL else action.tag)

    @override
    def end(self) -> None:
        self._adapter.running = True  # the test continues


def run_tests(adapter: Adapter, words: str) -> None:
    """Run pytest with an adapter that debugs its benches."""
    import pytest

    class TestPlugin:
        """A pytest plugin that registers the adapter for the benches of this run."""

        def pytest_configure(self, config: pytest.Config) -> None:
            """Register a function that is called with each bench."""
            config.pluginmanager.register(lambda bench: InTest(adapter, bench), DEBUGGER)

    pytest.main([*shlex.split(words), "--scanrack-keep=never"], plugins=[TestPlugin()])
