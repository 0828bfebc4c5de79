"""A networked drive advanced once or in pieces shows the same words at the same instants.

Deliberate breaks seen to turn this red: sampling the inputs at the end of each call; leaving an instant that
falls on the end of a call to the next one; noting the lead of the motor over the shaft at each call.
"""

from __future__ import annotations

from typing import Any

import pytest
from drive_unit import ENABLE, VALID
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.models import MODELS
from scanrack.runtime.machine import Jam, Machine, MachineSpec, Slip, Switch
from scanrack.runtime.modules.drives.drive import DriveUnit

TICK_NS = 250_000
MOVES = (2, 0x80, 0x100, 0x20, 0x40)

configurations = st.builds(
    lambda first, second, encoder, formats, start: (
        0x8000 | first | second << 3 | encoder,
        formats,
        *start,
        2048,
        0,
        1024,
        20,
        28,
        0,
    ),
    st.sampled_from([1, 7, 7, 4, 3, 5, 6]),
    st.sampled_from([0, 0, 2, 6, 4]),
    st.sampled_from([0, 0x0400, 0x2400]),
    st.sampled_from([*[0x0003] * 6, 0x0000, 0x0303, 0x0703, 0x4003, 0x0803]),
    st.sampled_from([(1, 0), (1, 0), (0, 50), (0, 0)]),
)
commands = st.builds(
    lambda bit, modifiers, target, speed, rates, last: (
        bit,
        ENABLE | modifiers,
        *target,
        *speed,
        *rates,
        *last,
    ),
    st.sampled_from([1 << bit for bit in range(15)] + [0, 0, 0, 2, 2, 0x80, 0x800, 0x1800, 0x2000, 3]),
    st.sampled_from([0, 0, 0, 0x80, 0x100, 0x04, 0x200, 0x10, 0x02, 0x800, 0x20, ENABLE, 0x40]),
    st.sampled_from([(0, 0), (3, 0), (0, 1), (-2, -500), (40, 0), (1, -1), (9000, 0)]),
    st.sampled_from([(0, 0), (1, 0), (5, 0), (90, 0), (3000, 0)]),
    st.sampled_from([(20, 10), (1, 2000), (5000, 5000), (0, 0)]),
    st.sampled_from([(0, 0), (28, 400), (15, 20), (0, 700), (9, 5001)]),
)
good = st.builds(
    lambda bit, modifiers, target, speed, rates, last: (
        bit,
        ENABLE | modifiers,
        *target,
        *speed,
        *rates,
        *last,
    ),
    st.sampled_from([2, 2, 2, 0x80, 0x100, 0x20, 0x40]),
    st.sampled_from([0, 0, 0, 0x100]),
    st.sampled_from([(3, 0), (-2, -500), (40, 0), (0, 100)]),
    st.sampled_from([(1, 0), (5, 0), (9, 0)]),
    st.sampled_from([(20, 10), (100, 100)]),
    st.sampled_from([(0, 0), (28, 400)]),
)
words = st.one_of(commands, commands, commands, configurations, st.just((0, ENABLE, *(0,) * 8)))
actions = st.tuples(
    st.integers(1, 6_000),
    st.one_of(words, good, good),
    st.dictionaries(st.sampled_from([InputBit.HOME, InputBit.CW_LIMIT]), st.booleans(), max_size=1),
    st.sampled_from([*[None] * 20, "cable", "plug", "hot", "cool", "stop", "run", "power"]),
)
machines = st.builds(
    lambda at, obstacle: MachineSpec(
        switches=(Switch(InputBit.HOME, at, at + 400),),
        slips=(Slip(1_200, 900, times=None),) if obstacle == 1 else (),
        jams=(Jam(2_000, 1),) if obstacle == 2 else (),
    ),
    st.sampled_from([700, -3_000, 1_500]),
    st.integers(0, 2),
)


def befall(drive, name):
    if name in ("cable", "plug"):
        drive.set_cable(name == "plug")
    elif name in ("hot", "cool"):
        drive.set_driver_fault(name == "hot")
    elif name in ("stop", "run"):
        drive.plc_run(name == "run")
    elif name == "power":
        drive.power_cycle()


def play(model, spec, script, pieces_ns):
    """Return what a drive shows at the end of each action, and its events."""
    drive = DriveUnit(MODELS[model], Machine(spec), {} if model == "anf2" else {"stored": list(VALID)})
    seen, now_ns, odd = [], 0, 123_457
    for ticks, outputs, inputs, what in script:
        befall(drive, what)
        for bit, level in inputs.items():
            drive.operate(bit, level)
        if outputs[0] in MOVES:  # after Reset Errors, so that it is carried out
            drive.obey((0x0400, ENABLE, *(0,) * 8))
            drive.obey((0, ENABLE, *(0,) * 8))
        drive.obey(outputs)
        end_ns = now_ns + ticks * TICK_NS + odd
        if pieces_ns:
            for instant in range(now_ns, end_ns, pieces_ns):
                drive.advance(instant)
                drive.inputs()
        drive.advance(end_ns)
        now_ns = end_ns
        seen.append(drive.inputs())
    return seen, [(event.at_ns, event.name) for event in drive.events], drive.memory


@given(
    model=st.sampled_from(sorted(MODELS)),
    spec=machines,
    configuration=configurations,
    script=st.lists(actions, min_size=1, max_size=8),
    pieces_ns=st.sampled_from([TICK_NS, 8 * TICK_NS, 37 * TICK_NS + 4_321]),
)
def test_pieces_show_the_same_words(model, spec, configuration, script, pieces_ns):
    head: list[Any] = [(4, configuration, {}, None), (4, (0, ENABLE, *(0,) * 8), {}, None)]
    assert play(model, spec, head + script, pieces_ns) == play(model, spec, head + script, 0)


@pytest.mark.parametrize("pieces_ns", [TICK_NS, 10_000_000])
def test_a_stall_is_detected_at_the_same_step(pieces_ns):
    spec = MachineSpec(jams=(Jam(1000, 1),))
    stalling = (0xA400, *VALID[1:6], 1024, *VALID[7:])
    script: list[Any] = [
        (4, stalling, {}, None),
        (4, (0, ENABLE, *(0,) * 8), {}, None),
        (4_000, (2, ENABLE, 20, 0, 5, 0, 20, 10, 0, 0), {}, None),
    ]
    seen, events, _ = play("smd23e2", spec, script, pieces_ns)
    assert "DRV-03" in [name for _, name in events]
    assert (seen, events) == play("smd23e2", spec, script, 0)[:2]
