"""The shaft's closed forms against a plain machine that makes one step after the other.

The plain machine is the law of each part said once more, in loops: it has no
tables, no look-ahead and no arithmetic beyond adding one.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from fractions import Fraction
from math import floor
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import EncoderSpec, Jam, Machine, MachineSpec, Slip, Switch

FAR_ENOUGH = 400  # single steps the plain machine tries before it says "never"


class PlainShaft:
    """Slips, jams, encoder and Z line, one motor step at a time."""

    def __init__(self, spec: MachineSpec, seed: int) -> None:
        self.spec = spec
        self.position = 0
        self.set_out = 0
        self.to_lose = 0
        self.left = [FAR_ENOUGH * 10 if slip.times is None else slip.times for slip in spec.slips]
        self.draws = [Random(f"{seed}/{index}") for index in range(len(spec.slips))]

    def step(self, direction: int) -> bool:
        """Make one motor step; return whether it gave a Z pulse."""
        before = self.shaft_counts()
        if Jam(self.position, direction) in self.spec.jams:
            self.set_out = 0
            return False
        if self.set_out != direction:
            self.set_out = direction
            self.to_lose = self.begin_slips(direction)
        if self.to_lose:
            self.to_lose -= 1
            return False
        self.position += direction
        self.set_out = 0
        return self.gives_marker(before, self.shaft_counts())

    def begin_slips(self, direction: int) -> int:
        lost = 0
        for index, slip in enumerate(self.spec.slips):
            if slip.at == self.position and slip.direction in (0, direction):
                drawn = Fraction(self.draws[index].getrandbits(32), 2**32) < Fraction(slip.chance)
                if drawn and self.left[index]:
                    self.left[index] -= 1
                    lost += slip.steps
        return lost

    def shaft_counts(self) -> int:
        encoder = self.spec.encoder
        return 0 if encoder is None else encoder.direction * floor(self.position * encoder.counts_per_step)

    def gives_marker(self, before: int, after: int) -> bool:
        encoder = self.spec.encoder
        if encoder is None or encoder.marker_every is None:
            return False
        step = 1 if after > before else -1
        met = range(before + step, after + step, step) if after != before else ()
        return any((count - encoder.marker_at) % encoder.marker_every == 0 for count in met)

    def switch_levels(self) -> int:
        levels = 0
        for bit in InputBit:
            wired = [switch for switch in self.spec.switches if switch.input == bit]
            inside = [
                (switch.first is None or self.position >= switch.first)
                and (switch.last is None or self.position <= switch.last)
                for switch in wired
            ]
            if wired and wired[0].normally_closed:
                levels |= 0 if any(inside) else bit.value
            else:
                levels |= bit.value if any(inside) else 0
        return levels

    def steps_until(self, direction: int, done: Callable[[PlainShaft, bool], bool]) -> int | None:
        """Count the steps until `done` holds, on a twin of this shaft."""
        twin = copy.deepcopy(self)
        if done(twin, False):
            return 0
        for steps in range(1, FAR_ENOUGH + 1):
            marker = twin.step(direction)
            if done(twin, marker):
                return steps
        return None


directions = st.sampled_from([1, -1])
positions = st.integers(-4, 4)  # few, so that they meet
slips = st.builds(
    Slip,
    at=positions,
    steps=st.integers(1, 6),
    direction=st.sampled_from([1, -1, 0]),
    times=st.one_of(st.none(), st.integers(1, 3)),
    chance=st.sampled_from([0, 0.25, 0.5, 1, Fraction(1, 3)]),
)
jams = st.builds(Jam, at=positions, direction=directions)
encoders = st.builds(
    EncoderSpec,
    counts_per_step=st.fractions(Fraction(1, 7), 9, max_denominator=7).filter(lambda ratio: ratio > 0),
    direction=directions,
    marker_every=st.one_of(st.none(), st.integers(1, 40)),
    marker_at=st.integers(-20, 20),
)


@st.composite
def switches(draw: st.DrawFn) -> tuple[Switch, ...]:
    """Draw switches, each input's of one kind."""
    made = []
    for bit in draw(st.lists(st.sampled_from(list(InputBit)), max_size=3, unique=True)):
        normally_closed = draw(st.booleans())
        for _ in range(draw(st.integers(1, 3))):
            first, last = draw(st.one_of(st.none(), positions)), draw(st.one_of(st.none(), positions))
            if first is not None and last is not None:
                first, last = min(first, last), max(first, last)
            made.append(Switch(bit, first, last, normally_closed))
    return tuple(made)


shaft_specs = st.builds(
    MachineSpec,
    switches=switches(),
    encoder=st.one_of(st.none(), encoders),
    slips=st.lists(slips, max_size=4).map(tuple),
    jams=st.lists(jams, max_size=2).map(tuple),
)
travels = st.lists(st.tuples(directions, st.integers(0, 15)), max_size=8)
seeds = st.integers(0, 3)


def after(spec: MachineSpec, seed: int, travel: list[tuple[int, int]]) -> tuple[Machine, PlainShaft]:
    """Return both machines after the same motor steps."""
    machine, plain = Machine(spec, seed), PlainShaft(spec, seed)
    for direction, steps in travel:
        machine.follow(direction, steps, 0)
        for _ in range(steps):
            plain.step(direction)
    return machine, plain


@given(shaft_specs, seeds, travels)
def test_follow_is_the_plain_machine(spec: MachineSpec, seed: int, travel: list[tuple[int, int]]) -> None:
    machine, plain = after(spec, seed, travel)
    assert machine.shaft == plain.position
    assert machine.levels(0) == plain.switch_levels()
    assert machine.encoder_counts(0) == plain.shaft_counts()


@given(shaft_specs, seeds, travels, st.data())
def test_follow_in_pieces_is_follow_at_once(
    spec: MachineSpec, seed: int, travel: list[tuple[int, int]], data: st.DataObject
) -> None:
    whole, pieces = Machine(spec, seed), Machine(spec, seed)
    for direction, steps in travel:
        whole.follow(direction, steps, 0)
        while steps:
            part = data.draw(st.integers(1, steps))
            pieces.follow(direction, part, 0)
            pieces.steps_to_shaft(direction, 5)  # asking changes nothing
            pieces.levels(0)
            steps -= part
    assert (pieces.shaft, pieces.levels(0)) == (whole.shaft, whole.levels(0))
    assert pieces.steps_to_shaft(1, 30) == whole.steps_to_shaft(1, 30)


def assert_foretold(foretold: int | None, steps: int | None) -> None:
    """Compare with what the plain machine found, as far as it looked."""
    assert steps == (foretold if foretold is not None and foretold <= FAR_ENOUGH else None)


@given(shaft_specs, seeds, travels, directions, st.integers(-40, 40))
def test_steps_to_shaft(
    spec: MachineSpec, seed: int, travel: list[tuple[int, int]], direction: int, target: int
) -> None:
    machine, plain = after(spec, seed, travel)
    steps = plain.steps_until(direction, lambda shaft, _: shaft.position == target)
    assert_foretold(machine.steps_to_shaft(direction, target), steps)


@pytest.mark.slow
@given(shaft_specs, seeds, travels, directions)
def test_steps_to_switch(spec: MachineSpec, seed: int, travel: list[tuple[int, int]], direction: int) -> None:
    machine, plain = after(spec, seed, travel)
    levels = plain.switch_levels()
    steps = plain.steps_until(direction, lambda shaft, _: shaft.switch_levels() != levels)
    assert_foretold(machine.steps_to_switch(direction), steps)


@given(shaft_specs, seeds, travels, directions, st.integers(-60, 60), st.integers(-9, 9))
def test_steps_to_counts(
    spec: MachineSpec, seed: int, travel: list[tuple[int, int]], direction: int, counts: int, by_hand: int
) -> None:
    machine, plain = after(spec, seed, travel)
    machine.turn_encoder(by_hand, 0, 0)
    steps = plain.steps_until(
        direction, lambda shaft, _: direction * (shaft.shaft_counts() + by_hand) >= direction * counts
    )
    assert_foretold(machine.steps_to_counts(direction, counts, 0), steps)


@given(shaft_specs, seeds, travels, directions)
def test_steps_to_marker(spec: MachineSpec, seed: int, travel: list[tuple[int, int]], direction: int) -> None:
    machine, plain = after(spec, seed, travel)
    steps = plain.steps_until(direction, lambda _, marker: marker)
    assert_foretold(machine.steps_to_marker(direction), steps)


@given(
    slips=st.lists(
        st.builds(Slip, at=st.integers(-(10**7), 10**7), steps=st.integers(1, 10**6), chance=st.just(0.5)),
        max_size=5,
    ),
    ratio=st.fractions(Fraction(1, 1000), 1000, max_denominator=1000).filter(lambda ratio: ratio > 0),
    start=st.integers(-(10**7), 10**7),
    direction=directions,
    distance=st.integers(1, 10**7),
)
def test_one_step_fewer_has_not_reached_it(
    slips: list[Slip], ratio: Fraction, start: int, direction: int, distance: int
) -> None:
    spec = MachineSpec(slips=tuple(slips), encoder=EncoderSpec(ratio, 1, 1000))
    machine = Machine(spec)
    machine.follow(1 if start > 0 else -1, abs(start), 0)
    target = machine.shaft + direction * distance
    counts = machine.encoder_counts(0) + direction * distance
    for steps, reached in (
        (machine.steps_to_shaft(direction, target), lambda twin: twin.shaft == target),
        (
            machine.steps_to_counts(direction, counts, 0),
            lambda twin: twin.encoder_counts(0) * direction >= counts * direction,
        ),
    ):
        assert steps is not None
        short, exact = copy.deepcopy(machine), copy.deepcopy(machine)
        short.follow(direction, steps - 1, 0)
        exact.follow(direction, steps, 0)
        assert not reached(short)
        assert reached(exact)
