"""What changes by time on the machine, against a plain machine that goes one ns at a time."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import Machine, MachineSpec, Station, Switch, TimelineEntry

directions = st.sampled_from([1, -1])
BUTTONS = (InputBit.CAPTURE, InputBit.EXTERNAL)  # the timeline's own
SIGNALS = (InputBit.HOME, InputBit.ESTOP)  # fed by stations and a switch, disturbed by the timeline
instants = st.integers(0, 60)
entries = st.one_of(
    st.builds(TimelineEntry, instants, st.sampled_from(BUTTONS), st.booleans()),
    st.builds(TimelineEntry, instants, st.sampled_from(SIGNALS), st.sampled_from([True, False, None])),
)
stations = st.builds(
    Station,
    position=st.integers(0, 2),
    input=st.just(InputBit.HOME),
    work_ns=st.integers(0, 12),
    pulse_ns=st.integers(1, 15),
)
timed_specs = st.builds(
    MachineSpec,
    switches=st.just((Switch(InputBit.ESTOP, 1, 1),)),
    timeline=st.lists(entries, max_size=8).map(tuple),
    stations=st.lists(stations, min_size=1, max_size=4).map(tuple),
)
END_NS = 90
all_instants = frozenset(range(END_NS))

# departs, comes to rest, direction; a step at each ns after the one and up to the other
Motion = tuple[int, int, int]


@st.composite
def motions(draw: st.DrawFn) -> list[Motion]:
    """Draw motions, one after the other, at rest between them for some time or none."""
    made, now_ns = [], 0
    for _ in range(draw(st.integers(0, 5))):
        departs = now_ns + draw(st.integers(0, 12))
        now_ns = departs + draw(st.integers(1, 3))
        made.append((departs, now_ns, draw(directions)))
    return made


class PlainInputs:
    """The inputs of a machine with timeline and stations, one ns at a time."""

    def __init__(self, spec: MachineSpec, motions: list[Motion]) -> None:
        self.spec = spec
        self.shaft = 0
        self.held: dict[InputBit, bool | None] = {}
        self.due = [station.work_ns if station.position == 0 else None for station in spec.stations]
        self.until = [0] * len(spec.stations)
        self.levels = [self.at(now_ns, motions) for now_ns in range(END_NS)]

    def at(self, now_ns: int, motions: list[Motion]) -> int:
        for entry in self.spec.timeline:
            if entry.at_ns == now_ns:
                self.held[entry.input] = entry.energized
        self.signal(now_ns)
        for departs, rests, direction in motions:
            self.shaft += direction if departs < now_ns <= rests else 0
            if now_ns == rests:
                self.due = [
                    now_ns + station.work_ns if station.position == self.shaft else None
                    for station in self.spec.stations
                ]
                self.signal(now_ns)
            if now_ns == departs:
                self.due = [None for _ in self.due]
        return sum(bit.value for bit in InputBit if self.energized(bit, now_ns))

    def signal(self, now_ns: int) -> None:
        for index, station in enumerate(self.spec.stations):
            if self.due[index] == now_ns:
                self.until[index] = now_ns + station.pulse_ns

    def energized(self, bit: InputBit, now_ns: int) -> bool:
        held = self.held.get(bit)
        if held is not None:
            return held
        switched = bit == InputBit.ESTOP and self.shaft == 1
        pulsed = any(
            station.input == bit and now_ns < until
            for station, until in zip(self.spec.stations, self.until, strict=True)
        )
        return switched or pulsed


def play(machine: Machine, motions: list[Motion], asked: frozenset[int]) -> dict[int, int]:
    """Run the motions; steps are told, and levels asked for, at the instants in `asked` only."""
    seen, owed = {}, 0
    for now_ns in range(END_NS):
        for departs, rests, direction in motions:
            if departs < now_ns <= rests:
                owed += 1
                if now_ns in asked or now_ns == rests:
                    machine.follow(direction, owed, now_ns)
                    owed = 0
            if now_ns == rests:
                machine.rest(now_ns)
            if now_ns == departs:
                machine.depart(now_ns)
        if now_ns in asked:
            seen[now_ns] = machine.levels(now_ns)
    return seen


@given(timed_specs, motions(), st.frozensets(st.integers(0, END_NS - 1)))
def test_levels_are_the_plain_machine_whenever_asked(
    spec: MachineSpec, motions: list[Motion], asked: frozenset[int]
) -> None:
    plain = PlainInputs(spec, motions).levels
    assert play(Machine(spec), motions, asked) == {now_ns: plain[now_ns] for now_ns in asked}


@given(timed_specs, motions(), st.frozensets(st.integers(0, END_NS - 1)))
def test_events_do_not_depend_on_when_levels_are_asked(
    spec: MachineSpec, motions: list[Motion], asked: frozenset[int]
) -> None:
    often, seldom = Machine(spec), Machine(spec)
    play(often, motions, all_instants)
    play(seldom, motions, asked | {END_NS - 1})
    assert seldom.events == often.events
    assert [event.at_ns for event in often.events] == sorted(event.at_ns for event in often.events)


@given(timed_specs)
def test_every_change_at_rest_is_announced(spec: MachineSpec) -> None:
    plain = PlainInputs(spec, []).levels
    machine, announced = Machine(spec), []
    now_ns = 0
    while (change_ns := machine.next_change_ns(now_ns)) is not None:
        now_ns = change_ns
        announced.append(now_ns)
    assert announced == sorted(set(announced))
    changes = {now_ns for now_ns in range(1, END_NS) if plain[now_ns] != plain[now_ns - 1]}
    working = [station for station in spec.stations if station.position == 0]
    reasons = {entry.at_ns for entry in spec.timeline}
    reasons |= {station.work_ns for station in working}
    reasons |= {station.work_ns + station.pulse_ns for station in working}
    assert changes <= set(announced) <= reasons


# --- the hand on the encoder

turns = st.lists(st.tuples(st.integers(0, 9), st.integers(0, 20), st.integers(-40, 40)), max_size=4)


def turned(turns: list[tuple[int, int, int]]) -> tuple[Machine, list[int]]:
    """Plan turns (pause, duration, counts); return the machine and its counts at each ns."""
    machine, planned, start_ns = Machine(), [], 0
    for pause, lasts, counts in turns:
        start_ns += pause
        machine.turn_encoder(counts, start_ns, start_ns + lasts)
        planned.append((start_ns, start_ns + lasts, counts))
        start_ns += lasts
    return machine, [sum(made(turn, now_ns) for turn in planned) for now_ns in range(140)]


def made(turn: tuple[int, int, int], now_ns: int) -> int:
    """Count on, one after the other, as long as the next one is not late."""
    start_ns, end_ns, counts = turn
    done = 0
    while (
        now_ns >= start_ns
        and done < abs(counts)
        and start_ns * abs(counts) + (done + 1) * (end_ns - start_ns) <= now_ns * abs(counts)
    ):
        done += 1
    return done if counts > 0 else -done


@given(turns, st.frozensets(st.integers(0, 139)))
def test_hand_turned_counts(turns: list[tuple[int, int, int]], asked: frozenset[int]) -> None:
    machine, plain = turned(turns)
    for now_ns in sorted(asked):
        assert machine.encoder_counts(now_ns) == plain[now_ns]


@given(turns, st.integers(0, 60))
def test_let_go_keeps_what_is_counted(turns: list[tuple[int, int, int]], now_ns: int) -> None:
    machine, plain = turned(turns)
    machine.let_go(now_ns)
    assert not machine.turning(now_ns)
    assert machine.encoder_counts(10**9) == plain[now_ns]
