"""Advancing once or in pieces gives the same images at the same instants (DESIGN: kinematics).

Deliberate breaks seen to turn this red: quantising a motion's end to the tick;
leaving a watched switch out of `StepGenerator.next_input_ns`; counting the
follower's steps from the instant of the update instead of the tick.
"""

from __future__ import annotations

from itertools import starmap

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime import Amci3601
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.testing.modules import Step, at_once, every, play

TICK_NS = 250_000
CONFIGURATIONS = [
    (0x843E, 0x3F, 1, 0),
    (0x843F, 0x3F, 0, 50),
    (0x853F, 0x3F, 1, 0),  # encoder
    (0x847E, 0x3F, 1, 0),  # backplane proximity
    (0x953F, 0x3F, 0, 200),  # marker homing, home switch as proximity
    (0x863E, 0x3F, 1, 0),  # diagnostic feedback
]
SPEEDS = [(0, 0), (0, 40), (1, 0), (5, 0), (90, 0), (0, -1), (2000, 0)]
TARGETS = [(0, 0), (3, 0), (0, 1), (-2, -500), (40, 0), (9000, 0), (1, -1)]
RATES = [(20, 10), (1, 2000), (2000, 2000), (0, 0), (7, 3)]

commands = st.builds(
    lambda msw, lsw, target, speed, rates: (msw, lsw, *target, *speed, *rates),
    st.sampled_from([1 << bit for bit in range(15)] + [0, 0, 0, 2, 2, 128, 3, 132]),
    st.sampled_from([0, 0, 0, 0, 1, 3, 4, 0x80, 0x100, 0x300, 0x400, 0x1000]),
    st.sampled_from(TARGETS),
    st.sampled_from(SPEEDS),
    st.sampled_from(RATES),
)
follower = st.builds(
    lambda msw, ratio, rates: (msw, 0x80, *ratio, 0, 0, *rates),
    st.sampled_from([0, 128, 256]),
    st.sampled_from([(1, 1), (7, 3), (3, 7)]),
    st.sampled_from([(0, 0), (50, 50), (0, 20)]),
)
words = st.one_of(
    commands,
    follower,
    st.sampled_from([(0,) * 8, (0x0800, *(0,) * 7), (0x0200, *(0,) * 7)]),
    st.sampled_from(CONFIGURATIONS).map(lambda head: (*head, 0, 0, 0, 0)),
)
actions = st.tuples(
    st.integers(1, 6_000),  # ticks until the next action
    words,
    st.dictionaries(
        st.sampled_from([InputBit.CAPTURE, InputBit.EXTERNAL, InputBit.ESTOP]), st.booleans(), max_size=1
    ),
    st.sampled_from([0, 0, 0, 300, -900, 5_000]),  # encoder counts turned by hand meanwhile
    st.sampled_from([True, True, True, True, True, False]),  # PLC in run mode
)
machines = st.builds(
    lambda home, cw, ccw: MachineSpec(
        switches=(
            Switch(InputBit.HOME, home, home + 400),
            Switch(InputBit.CW_LIMIT, cw, None),
            Switch(InputBit.CCW_LIMIT, None, ccw),
        )
    ),
    st.sampled_from([-3_000, 1_500, 700]),
    st.sampled_from([2_500, 60_000]),
    st.sampled_from([-4_000, -60_000]),
)


def _play(spec, script, pieces):
    """Return what the module shows at the script's instants, called in pieces as well."""
    module = Amci3601("4.1", Machine(spec), diagnostic_wiring=True)
    return play(module, list(starmap(_step, script)), pieces)


def _step(ticks, words, inputs, counts, running):
    def act(module, begin_ns, end_ns):
        for bit, level in inputs.items():
            module.machine.set_input(bit, level)
        if counts:
            module.machine.turn_encoder(counts, begin_ns, end_ns)
        module.look_again()

    return Step(ticks * TICK_NS, words, running, act)


@pytest.mark.slow
@given(
    spec=machines,
    config=st.sampled_from(CONFIGURATIONS),
    script=st.lists(actions, min_size=1, max_size=7),
    period=st.sampled_from([1, 8, 37]),
    odd_ns=st.sampled_from([0, 0, 123_457]),
)
def test_pieces_give_the_same_images(spec, config, script, period, odd_ns):
    head: tuple[object, ...] = (4, (*config, 0, 0, 0, 0), {}, 0, True)
    zero: tuple[object, ...] = (4, (0x0000, *(0,) * 7), {}, 0, True)
    script = [head, zero, *script]
    assert _play(spec, script, every(period * TICK_NS + odd_ns)) == _play(spec, script, at_once)
