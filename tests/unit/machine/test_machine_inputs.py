"""Timeline, stations and the bench: what changes inputs by time."""

from __future__ import annotations

import pytest
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import Machine, MachineSpec, Station, Switch, TimelineEntry, press

HOME, ESTOP, EXTERNAL, CAPTURE = InputBit.HOME, InputBit.ESTOP, InputBit.EXTERNAL, InputBit.CAPTURE
MS = 1_000_000


def test_a_press_holds_for_its_time() -> None:
    machine = Machine(MachineSpec(timeline=press(3200 * MS, ESTOP, 50 * MS)))
    assert machine.next_change_ns(0) == 3200 * MS
    assert machine.levels(3200 * MS - 1) == 0
    assert machine.levels(3200 * MS) == ESTOP
    assert machine.next_change_ns(3200 * MS) == 3250 * MS
    assert machine.levels(3250 * MS - 1) == ESTOP
    assert machine.levels(3250 * MS) == 0
    assert machine.next_change_ns(3250 * MS) is None


def test_entries_act_by_time_and_at_one_instant_in_the_order_given() -> None:
    timeline = (TimelineEntry(20, HOME, True), TimelineEntry(10, HOME, False), TimelineEntry(10, HOME, True))
    machine = Machine(MachineSpec(timeline=timeline))
    machine.levels(100)
    assert [(event.at_ns, event.fields["energized"]) for event in machine.events] == [
        (10, False),
        (10, True),
        (20, True),
    ]


@pytest.mark.parametrize("told", ["depart", "rest", "next_change_ns"])
def test_levels_see_what_acted_while_others_asked(told: str) -> None:
    machine = Machine(MachineSpec(timeline=press(10, ESTOP, 10)))
    machine.depart(0)
    assert machine.levels(0) == 0
    getattr(machine, told)(10)
    assert machine.levels(10) == ESTOP


def test_an_entry_at_the_start_is_there_from_the_start() -> None:
    assert Machine(MachineSpec(timeline=(TimelineEntry(0, ESTOP, True),))).levels(0) == ESTOP


def test_a_stuck_switch_and_its_repair() -> None:
    spec = MachineSpec(
        switches=(Switch(HOME, 10, 20),),
        timeline=(TimelineEntry(5, HOME, True), TimelineEntry(9, HOME, False), TimelineEntry(15, HOME, None)),
    )
    machine = Machine(spec)
    assert [machine.levels(now_ns) for now_ns in (4, 5)] == [0, HOME]
    machine.follow(1, 12, 8)
    assert [machine.levels(now_ns) for now_ns in (8, 9, 14, 15)] == [HOME, 0, 0, HOME]
    assert machine.steps_to_switch(1) == 9


def test_the_bench_drives_what_the_machine_leaves_free() -> None:
    spec = MachineSpec(
        switches=(Switch(HOME, 0, 5),), stations=(Station(9, EXTERNAL, 0, 1),), timeline=press(5, ESTOP, 5)
    )
    machine = Machine(spec)
    machine.set_input(CAPTURE, True)
    assert machine.levels(0) == CAPTURE | HOME
    machine.set_input(CAPTURE, False)
    assert machine.levels(0) == HOME
    for bit in (HOME, EXTERNAL, ESTOP):
        with pytest.raises(ValueError, match=f"set_input: {bit.name} is wired to the machine; choose"):
            machine.set_input(bit, True)
    assert machine.levels(0) == HOME


# --- stations: 100 ns of work at position 4000, then a pulse of 30

STATION = Station(4000, EXTERNAL, 100, 30)


def arrived(at_ns: int, *, stations: tuple[Station, ...] = (STATION,)) -> Machine:
    """Return a machine that has come to rest at 4000."""
    machine = Machine(MachineSpec(stations=stations))
    machine.follow(1, 4000, at_ns)
    machine.rest(at_ns)
    return machine


def test_a_station_works_and_signals() -> None:
    machine = arrived(1000)
    assert machine.next_change_ns(1000) == 1100
    assert [machine.levels(now_ns) for now_ns in (1099, 1100, 1129, 1130)] == [0, EXTERNAL, EXTERNAL, 0]
    assert machine.next_change_ns(1130) is None


def test_a_station_next_to_the_position_does_nothing() -> None:
    machine = Machine(MachineSpec(stations=(STATION,)))
    machine.follow(1, 4001, 1000)
    machine.rest(1000)
    assert machine.next_change_ns(1000) is None


def test_a_station_that_is_passed_does_nothing() -> None:
    machine = Machine(MachineSpec(stations=(STATION,)))
    machine.follow(1, 4000, 1000)
    machine.follow(1, 4000, 2000)
    machine.rest(2000)
    assert machine.next_change_ns(2000) is None


def test_a_station_under_the_shaft_at_the_start_works_at_once() -> None:
    machine = Machine(MachineSpec(stations=(Station(0, EXTERNAL, 100, 30),)))
    assert machine.next_change_ns(0) == 100
    machine.rest(50)  # it rests already: no news
    assert machine.next_change_ns(50) == 100


@pytest.mark.parametrize("steps_told", [0, 1])
def test_leaving_early_cancels_the_pulse(steps_told: int) -> None:
    machine = arrived(1000)
    if steps_told:
        machine.follow(1, steps_told, 1099)
    else:
        machine.depart(1099)
    assert machine.next_change_ns(1099) is None
    assert machine.levels(1110) == 0
    assert machine.events == []


def test_leaving_as_the_pulse_begins_leaves_it_its_time() -> None:
    machine = arrived(1000)
    machine.depart(1100)
    machine.follow(1, 20, 1110)
    assert [machine.levels(now_ns) for now_ns in (1110, 1129, 1130)] == [EXTERNAL, EXTERNAL, 0]


def test_no_step_is_no_departure() -> None:
    machine = arrived(1000)
    machine.follow(1, 0, 1050)
    assert machine.next_change_ns(1050) == 1100


def test_coming_back_works_again() -> None:
    machine = arrived(1000)
    machine.follow(1, 5, 1200)
    machine.follow(-1, 5, 1300)
    machine.rest(1300)
    assert machine.next_change_ns(1300) == 1400


def test_a_pulse_due_while_the_last_one_lasts_prolongs_it() -> None:
    machine = arrived(1000, stations=(Station(4000, EXTERNAL, 10, 100),))  # pulse from 1010 to 1110
    machine.follow(1, 5, 1020)
    machine.follow(-1, 5, 1040)
    machine.rest(1040)  # again from 1050 to 1150
    assert [machine.levels(now_ns) for now_ns in (1040, 1050, 1110, 1149, 1150)] == [EXTERNAL] * 4 + [0]


def test_stations_may_share_an_input() -> None:
    spec = MachineSpec(stations=(Station(0, EXTERNAL, 10, 20), Station(0, EXTERNAL, 20, 20)))
    machine = Machine(spec)
    assert [machine.levels(now_ns) for now_ns in (9, 10, 30, 39, 40)] == [0, EXTERNAL, EXTERNAL, EXTERNAL, 0]


def test_a_station_that_needs_no_time_signals_as_the_motion_ends() -> None:
    assert arrived(1000, stations=(Station(4000, EXTERNAL, 0, 1),)).levels(1000) == EXTERNAL


# --- events


def test_events_are_sentences_in_order_of_time() -> None:
    spec = MachineSpec(
        switches=(Switch(InputBit.CW_LIMIT, 9000, None),),
        stations=(Station(0, EXTERNAL, 40, 20),),
        timeline=(
            *press(50, ESTOP, 50),
            TimelineEntry(45, InputBit.CW_LIMIT, False),
            TimelineEntry(70, InputBit.CW_LIMIT, None),
        ),
    )
    machine = Machine(spec)
    machine.next_change_ns(1000)
    assert [(event.at_ns, event.kind, event.name, event.text) for event in machine.events] == [
        (40, "stimulus", "external", "The station at 0 is done and signals it."),
        (45, "stimulus", "cw_limit", "The CW limit input stays de-energized, whatever the machine does."),
        (50, "stimulus", "estop", "The emergency stop input is energized."),
        (60, "stimulus", "external", "The station at 0 ends its signal."),
        (70, "stimulus", "cw_limit", "The CW limit input follows the machine again."),
        (100, "stimulus", "estop", "The emergency stop input is de-energized."),
    ]


def test_emptied_events_stay_gone() -> None:
    machine = Machine(MachineSpec(timeline=press(5, HOME, 5)))
    machine.levels(5)
    machine.events.clear()
    machine.levels(10)
    assert [event.at_ns for event in machine.events] == [10]
