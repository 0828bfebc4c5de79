"""Sessions without a monitor: orders from a list, answers into one."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.runtime.live.ring import ROWS, Ring
from scanrack.runtime.live.session import Session
from scanrack.runtime.live.tap import Tap
from scanrack.runtime.loop.pace import AdjustablePace
from scanrack.watch.history.watched_machines import PER_SLOT, MachineFigures
from scanrack.watch.history.watched_program import LadderNotes, written_to

FEEDER = Path(__file__).parents[2] / "examples" / "feeder" / "feeder.toml"


class Script:
    """Orders that come when a scan has been reached; during a pause the next one comes at once."""

    def __init__(self, orders):
        self._orders = list(orders)
        self.session: Any = None

    def pending(self):
        if not self._orders:
            return False
        return self.session.state.paused or self._orders[0][0] <= self.session.scan

    def take(self):
        scan, order = self._orders.pop(0)
        return order if isinstance(order, bytes) else json.dumps({"id": scan, "order": order}).encode()

    def wait(self, seconds):
        if not self._orders:
            self.session.end()


class LiveSession:
    """A rack in a session; orders are (scan, message)."""

    def __init__(
        self, orders=(), trace=None, rack=FEEDER, *, live=False, rows=None, ring=None, editions=None
    ):
        self.told = []
        self.ports = ExitStack()
        job = load_job(str(rack))
        pacer = AdjustablePace(None)
        self.run = JobRun(
            job, self.ports, RunOptions(trace=trace, pacer=pacer, handled=True, editions=editions)
        )
        self.program = self.run.program.debugger
        figures = MachineFigures(self.run.rack)
        self.machines = figures.slots
        self.ring = ring or Ring(len(self.run.rack.memory), PER_SLOT * len(figures.slots), rows or ROWS)
        self.tap = Tap(self.ring, self.run.rack, self.run.cpu.period_ns, figures)
        if self.program is not None:
            self.tap.notes = LadderNotes(self.program, written_to(self.ring.snapshots))
        inbox = Script(orders)
        self.session = Session(
            self.run.cpu, self.run.hands, pacer, inbox, self.tell, stops=self.program, live=live
        )
        inbox.session = self.tap.session = self.session
        self.session.attend = self.tap.attend
        self.run.cpu.add_listener(self.tap)

    def tell(self, message):
        self.told.append(message)

    @property
    def answers(self):
        return [each["answer"] for each in self.told if "answer" in each]

    @property
    def refusals(self):
        return [each["refused"] for each in self.answers if "refused" in each]

    def play(self, scans=None, *, paused=False):
        with self.ports, self.run.cpu:
            self.session.run(scans, paused=paused)
        return self
