"""Listeners that receive scans by rows: what ends rows in the middle, and what was received by then."""

from __future__ import annotations

import pytest
from scanrack.io_images.amci3601 import Configuration, Direction, Idle, InputBit, Manual
from scanrack.runtime import Amci3601, Card, Cpu, CpuFault, CpuMode, Rack
from scanrack.runtime.loop import ahead
from scanrack.runtime.loop.listeners import by_rows

MS = 1_000_000
AT = 700
SCRIPT = (
    Configuration(
        inputs_used=InputBit.HOME | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=1000
    ).to_image(),
    Idle().to_image(),
    Manual(Direction.CW, 5000, 20, 10).to_image(),
)


class Rows:
    """Notes events and scans, and how many scans came at once; raises at scan `fails`."""

    look = None

    def __init__(self, memory: bytearray, fails: int = -1) -> None:
        self.memory, self.fails = memory, fails
        self.told: list[object] = []
        self.at_once: list[int] = []

    def event(self, scan, now_ns, topic, fields) -> None:
        self.told.append((scan, now_ns, topic, dict(fields)))

    def scan(self, scan, now_ns, flags) -> None:
        self.told.append((scan, now_ns, flags, bytes(self.memory)))
        self.fail_in([scan])

    def begin_rows(self, scan) -> int:
        return max(1, self.fails + 1 - scan) if self.fails >= scan else 4096

    def rows(self, scans, times, flags, images) -> None:
        self.at_once.append(len(scans))
        self.told += [(*pair, flags, image) for *pair, image in zip(scans, times, images, strict=True)]
        self.fail_in(scans)

    def fail_in(self, scans) -> None:
        if self.fails in scans:
            raise OSError("no room")

    def close(self) -> None:
        self.told.append("closed")


@pytest.fixture(autouse=True)
def _numpy_is_loaded(monkeypatch):
    monkeypatch.setattr(ahead, "NUMPY_WORTH_SCANS", 0)


def ran(does, *, by_rows: bool, fails: int = -1) -> tuple[Cpu, Rows]:
    """Run 1,000 scans of an axis in mid-move; the logic does something at scan 700."""
    rack = Rack([Card(1, Amci3601(), "amci3601", "4.1")])
    listener = Rows(rack.memory, fails)

    def logic(scan) -> None:
        scan.slot[1].outputs.load(SCRIPT[min(scan.number, len(SCRIPT) - 1)])
        if scan.number == AT:
            does(cpu)

    cpu = Cpu(rack, logic, 2 * MS, listeners=[listener])
    cpu._ahead.enabled = by_rows
    try:
        cpu.run(1000)
        cpu.close()
    except CpuFault:
        pass
    return cpu, listener


def raise_error(cpu: Cpu) -> None:
    raise KeyError("lamp")


def replace_program(cpu: Cpu) -> None:
    cpu.program = lambda scan: scan.slot[1].outputs.clear()


ACTIONS = {
    "nothing": lambda cpu: None,
    "raises": raise_error,
    "stops": Cpu.stop,
    "replaces": replace_program,
    "mode": lambda cpu: setattr(cpu, "mode", CpuMode.PROGRAM),
    "force": lambda cpu: cpu.forces.set("I:1.3", 77),
    "exchange": Cpu.exchange_early,
    "power": lambda cpu: cpu.rack.slots[1].module.power_cycle(),
    "leaves": lambda cpu: cpu.dismiss(cpu._listeners.listeners[0]),
    "outputs": lambda cpu: cpu.rack.slots[1].outputs.clear(),
}


@pytest.mark.parametrize("does", ACTIONS.values(), ids=ACTIONS)
def test_what_the_logic_does_within_rows_is_noted_as_scan_by_scan(does):
    slow_cpu, slow = ran(does, by_rows=False)
    fast_cpu, fast = ran(does, by_rows=True)
    assert fast.told == slow.told
    assert (fast_cpu.scan, fast_cpu.now_ns) == (slow_cpu.scan, slow_cpu.now_ns)
    assert str(fast_cpu.fault) == str(slow_cpu.fault)
    assert max(fast.at_once) > 16
    assert not slow.at_once


def test_a_new_listener_receives_the_scan_in_which_it_is_added():
    def told(by_rows: bool) -> list[object]:
        added: list[Rows] = []

        def add(cpu: Cpu) -> None:
            added.append(Rows(cpu.rack.memory))
            cpu.add_listener(added[0])

        ran(add, by_rows=by_rows)
        return added[0].told

    assert told(True) == told(False)
    assert len(told(True)) == 1000 - AT + 1


def test_rows_of_a_block_that_has_ended_are_not_received_again():
    rack = Rack([Card(1, Amci3601(), "amci3601", "4.1")])
    listener, added = Rows(rack.memory), Rows(rack.memory)
    cpu = Cpu(rack, lambda scan: cpu.stop() if scan.number == AT else None, 2 * MS, listeners=[listener])
    cpu.run(1000)
    for _ in range(3):
        cpu.run(1)
    cpu.add_listener(added)
    assert max(listener.at_once) > 16
    assert [scan for scan, _, flags, _ in listener.told if isinstance(flags, int)] == [*range(AT + 4)]


@pytest.mark.parametrize("fails", [AT - 1, AT, AT + 1])
def test_a_listener_that_fails_is_to_blame_at_its_own_scan(fails):
    slow_cpu, slow = ran(lambda cpu: None, by_rows=False, fails=fails)
    fast_cpu, fast = ran(lambda cpu: None, by_rows=True, fails=fails)
    assert fast.told == slow.told
    assert str(fast_cpu.fault) == str(slow_cpu.fault)
    assert f"scan {fails} " in str(fast_cpu.fault)
    assert "a listener failed" in str(fast_cpu.fault)


def test_one_listener_without_rows_has_every_scan_passed_by_itself():
    class Plain:
        def __init__(self, memory):
            self.all = Rows(memory)
            self.told = self.all.told
            self.event, self.scan, self.close = self.all.event, self.all.scan, self.all.close

    rack = Rack([Card(1, Amci3601(), "amci3601", "4.1")])
    listeners = [Rows(rack.memory), Plain(rack.memory)]
    assert [by_rows(each) for each in listeners] == [listeners[0], None]
    Cpu(rack, lambda scan: None, 2 * MS, listeners=listeners).run(500)
    assert listeners[0].told == listeners[1].told
    assert not listeners[0].at_once
