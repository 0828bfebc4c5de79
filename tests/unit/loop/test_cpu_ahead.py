"""Scans by rows: when they are used, and what ends them. That they show the same: test_look_ahead.py."""

from __future__ import annotations

import itertools

import pytest
from scanrack.io_images.amci3601 import Configuration, Direction, Idle, InputBit, Manual
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime import Amci3601, Card, Cpu, CpuFault, CpuMode, FaultKind, InjectedFault, Rack
from scanrack.runtime.loop import ahead
from scanrack.runtime.loop.exchange import EveryRpi
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.modules.cards.module import GenericCard

MS = 1_000_000
SCRIPT = (
    Configuration(
        inputs_used=InputBit.HOME | InputBit.CW_LIMIT, step_and_direction=True, starting_speed=1000
    ).to_image(),
    Idle().to_image(),
    Manual(Direction.CW, 5000, 20, 10).to_image(),
)


def moving(scan):
    """A manual move from the third scan on."""
    for slot in scan.slot.values():
        slot.outputs.load(SCRIPT[min(scan.number, len(SCRIPT) - 1)])


@pytest.fixture(autouse=True)
def _numpy_is_loaded(monkeypatch):
    monkeypatch.setattr(ahead, "NUMPY_WORTH_SCANS", 0)


class Counting(Amci3601):
    """A 3601 that counts its updates."""

    updates = 0

    def update(self, now_ns: int, outputs: Image) -> Image:
        self.updates += 1
        return super().update(now_ns, outputs)


class Listener:
    """Acts at the end of some scans, and keeps position and events."""

    def __init__(self, rack: Rack, actions=()) -> None:
        self.rack, self.actions = rack, dict(actions)
        self.positions: list[int] = []
        self.captured: list[int] = []
        self.events: list[tuple[int, str, object]] = []

    def event(self, scan, now_ns, topic, fields) -> None:
        self.events.append((scan, topic, fields.get("name")))

    def scan(self, scan, now_ns, flags) -> None:
        words = self.rack.slots[1].inputs
        self.positions.append(join_reported(words[2], words[3]))
        self.captured.append(words[7])
        self.actions.get(scan, lambda: None)()

    def close(self) -> None:
        pass


def cpu_of(module, logic=moving, actions=(), **options):
    rack = Rack([Card(1, module, "amci3601", "4.1")])
    listener = Listener(rack, actions)
    return Cpu(rack, logic, 2 * MS, listeners=[listener], **options), listener


def test_a_module_in_mid_move_is_updated_in_few_scans_of_many():
    cpu, listener = cpu_of(module := Counting())
    cpu.run(10_000)
    assert module.updates < 200
    # chapter 2: 0.2 s and 600 steps of ramp from 1000 to 5000 steps/s, then 10 steps per scan
    assert listener.positions[102:] == [600 + 10 * scan for scan in range(10_000 - 102)]


def test_at_rest_a_module_is_updated_once_in_a_while():
    cpu, _ = cpu_of(module := Counting(), lambda scan: None)
    cpu.run(10_000)
    assert module.updates < 20


def test_without_numpy_short_runs_do_not_load_it(monkeypatch):
    monkeypatch.setattr(ahead, "NUMPY_WORTH_SCANS", 3000)
    monkeypatch.setattr(ahead, "sys", type("Sys", (), {"modules": {}}))
    cpu, _ = cpu_of(module := Counting())
    cpu.run(3000)
    assert module.updates == 3000


def test_new_outputs_are_seen_in_their_own_scan():
    """Hold at scan 1000: the module brakes from there on, as if every scan had been a module's."""

    def holding(scan):
        moving(scan)
        if scan.number >= 1000:
            scan.slot[1].outputs.load(Idle().to_image())

    def positions(looks_ahead):
        cpu, listener = cpu_of(Amci3601(), holding)
        cpu._ahead.enabled = looks_ahead
        cpu.run(2000)
        return listener.positions

    found = positions(True)
    assert found[1000] == 600 + 10 * (1000 - 102)
    assert found[1001] < found[1000] + 10  # it brakes
    assert found == positions(False)


def test_logic_that_writes_something_new_in_every_scan_goes_by_phases():
    def restless(scan):
        scan.slot[1].outputs[7] = scan.number & 0xFF

    cpu, _ = cpu_of(module := Counting(), restless)
    cpu.run(1000)
    assert module.updates >= 1000


def test_one_module_that_can_not_tell_has_all_go_by_phases(new_module):
    rack = Rack([Card(1, module := Counting()), Card(2, new_module())])
    Cpu(rack, lambda scan: None, 2 * MS).run(1000)
    assert module.updates == 1000


@pytest.mark.parametrize("how", ["mode", "force", "stop"])
def test_requests_of_listeners_take_effect_in_the_next_scan(how):
    cpu, listener = cpu_of(Amci3601())
    requests = {
        "mode": lambda: setattr(cpu, "mode", CpuMode.PROGRAM),
        "force": lambda: cpu.forces.set("I:1.3", 77),
        "stop": cpu.stop,
    }
    listener.actions[500] = requests[how]
    cpu.run(600)
    if how == "stop":
        assert len(listener.positions) == 501
    else:
        assert (501, "/cpu" if how == "mode" else "/forces", None) in listener.events


def test_a_force_that_is_let_go_leaves_nothing_in_the_rows():
    cpu, listener = cpu_of(Amci3601())
    listener.actions = {500: lambda: cpu.forces.set("I:1.7", 77), 510: cpu.forces.clear}
    cpu._ahead.patience.wait = 511  # a block begins right after the last scan with a force
    cpu.run(1000)
    assert listener.captured[2:] == [0] * 499 + [77] * 10 + [0] * 489  # the first shows the configuration


def test_a_power_cycle_in_mid_block_stops_the_shaft_where_it_is():
    module = Amci3601()
    cpu, listener = cpu_of(module, actions={500: module.power_cycle})
    cpu.run(600)
    assert module.machine.shaft == 600 + 10 * (500 - 102)
    assert (501, "/events", "CER-01") in listener.events


def test_events_of_a_touch_are_told_before_the_next_block():
    """Between two exchanges of a CompactLogix the inputs are known, but the event is not to wait for that."""
    module = Amci3601()
    cpu, listener = cpu_of(module, lambda scan: None, {500: module.power_cycle}, exchange=EveryRpi(100 * MS))
    cpu._ahead.patience.wait = 501
    cpu.run(600)
    assert (501, "/events", "CER-01") in listener.events


def test_a_torn_update_is_not_looked_over():
    """The words that come late come 1 s after the change, in the middle of what would be a block at rest."""
    changed = 300

    def logic(scan):
        scan.slot[1].outputs[7] = 5 if scan.number >= changed else 0

    late = InjectedFault(0, FaultKind.TORN_UPDATE, 1, 1000 * MS, (7,))
    seen = []

    class Seeing(Counting):
        def update(self, now_ns, outputs):
            seen.append(outputs[7])
            return super().update(now_ns, outputs)

    cpu, _ = cpu_of(ExposedModule(Seeing(), [late]), logic)
    cpu.run(2000)
    # the update after the change covers scan 300 to 301 and still carries 0; 5 comes 1 s = 500 scans later
    assert [value for value, _ in itertools.groupby(seen)] == [0, 5]
    assert seen.index(5) > 500


def test_what_the_logic_raises_in_a_block_finds_the_modules_at_the_present():
    def failing(scan):
        moving(scan)
        if scan.number == 1000:
            raise KeyError("lamp")

    module = Amci3601()
    cpu, _ = cpu_of(module, failing)
    with pytest.raises(CpuFault, match=r"scan 1000 .*KeyError"):
        cpu.run(2000)
    module.update(2002 * MS, Image())
    assert not module.axis.moving  # the PLC has left run mode at the scan's instant
    assert module.machine.shaft == 600 + 10 * (1000 - 102)


def test_outputs_that_somebody_else_writes_are_sent():
    """What a listener writes into an output image is sent with the next scan."""
    cpu, listener = cpu_of(Amci3601(), lambda scan: moving(scan) if scan.number < 3 else None)
    listener.actions[500] = cpu.rack.slots[1].outputs.clear
    cpu._ahead.patience.wait = 501
    cpu.run(1000)
    assert listener.positions[-1] == listener.positions[-100]  # it has stopped


def test_a_card_at_rest_and_a_changed_lamp():
    card = GenericCard()
    rack = Rack([Card(1, Counting()), Card(2, card)])
    lit = []

    def logic(scan):
        scan.slot[2].outputs[0] = int(scan.number >= 700)
        lit.append(card.lit)

    Cpu(rack, logic, 2 * MS).run(1000)
    assert lit == [0] * 701 + [1] * 299


def test_figures_are_those_of_the_scan():
    """A person who looks at the machine in mid-move sees the shaft where it is."""
    module = Amci3601()
    seen: list[int] = []
    cpu, listener = cpu_of(module, actions={500: lambda: seen.append(module.figures()[0])})
    cpu.run(1000)
    assert seen == [600 + 10 * (500 - 102)]
    assert listener.positions[-1] == 600 + 10 * (999 - 102)


class RepeatsTen:
    """Finds ten repeated scans whenever it is called."""

    def __init__(self) -> None:
        self.found: list[tuple[int, int, int]] = []

    def keep(self) -> None:
        pass

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        self.found.append((scan, now_ns, most))
        return min(10, most)


def test_scans_that_are_passed_over_take_their_time():
    cpu, listener = cpu_of(module := Amci3601(), logic=lambda scan: None)
    every, _ = cpu_of(other := Amci3601(), logic=lambda scan: None)
    cpu.pass_over_repeats(finder := RepeatsTen())
    cpu.run(1_000)
    every.run(1_000)
    assert (cpu.scan, cpu.now_ns) == (1_000, 2_000 * MS)
    assert len(listener.positions) == 1_000 - sum(min(10, most) for _, _, most in finder.found)
    assert all(now_ns == 2 * MS * (scan - 1) for scan, now_ns, _ in finder.found)
    assert module.update(cpu.now_ns, Image()).raw == other.update(every.now_ns, Image()).raw


def test_no_scan_of_a_move_is_passed_over():
    cpu, listener = cpu_of(Amci3601())
    every, expected = cpu_of(Amci3601())
    cpu.pass_over_repeats(RepeatsTen())
    cpu.run(1_000)
    every.run(1_000)
    assert listener.positions == expected.positions
