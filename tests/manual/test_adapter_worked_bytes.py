"""One move in the bytes of both lines: RELATIVE +2500 at 5000 steps/s, 100 steps/ms/s, from 500 steps/s.

100 steps/ms/s are 100,000 steps/s/s = 0001 86A0h in the PCL601's registers, the low word first
[Appendix 1]; on a PMC006 coefficient 1, 77,440 PPS2, is the steepest ramp that is not above [4.3.3].
"""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from adapterbench import AdapterBench, AdapterBench006, move
from overheard import Overheard

READ_601 = ["01 03 00 1f 00 05 b4 0f", "01 04 00 00 00 01 31 ca", "01 03 00 0c 00 02 04 08"]
"""Encoder, busy, errors; inputs; position."""

START_601 = [
    "01 10 00 01 00 08 10 09 c4 00 00 86 a0 00 01 01 f4 13 88 13 88 00 01 f0 2c",  # steps to direction
    "01 06 00 00 00 01 48 0a",  # code 1, Go
]
READ_006 = [
    "a5 01 6a 00 00 00 00 10",  # j
    "a5 01 63 00 00 00 00 09",  # c
    "a5 01 78 00 00 00 00 1e",  # x
    "a5 01 4f 00 00 00 00 f5",  # O, each tenth time
]

START_006 = [
    "a5 01 76 88 13 00 00 b7",  # v 5000
    "a5 01 75 01 00 00 00 1c",  # u 1
    "a5 01 6f 01 00 00 00 16",  # o 1
    "a5 01 64 01 00 00 00 0b",  # d 1
    "a5 01 73 c4 09 00 00 e6",  # s 2500
]


def said(bench: AdapterBench, words: Iterable[int], ms: int) -> tuple[set[str], list[str]]:
    """Give words; return the questions that were asked, and everything else that was said."""
    heard = Overheard(bench)
    bench.give(*words, ms=ms)
    frames = [frame.hex(" ") for frame, _ in heard.frames]
    reads = {*READ_601, *READ_006}
    return reads & set(frames), [frame for frame in frames if frame not in reads]


@pytest.mark.parametrize(
    ("kind", "configuration", "reads", "start"),
    [
        (AdapterBench, (0x843E, 63, 0, 500), READ_601, START_601),
        (AdapterBench006, (0x843C, 63, 0, 500), READ_006, START_006),
    ],
    ids=["PCL601", "PMC006"],
)
def test_a_relative_move(kind, configuration, reads, start):
    bench = kind().configured(*configuration)
    assert said(bench, move(2500, 5000, 100, 100), 1500) == (set(reads), start)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == 2500


def test_a_hold_is_a_soft_stop_and_a_stop_at_base_speed():
    """Code 6; 45 ms of ramp down, 4,500 steps/s at 100 steps/ms/s, and what is read meanwhile; code 5."""
    bench = AdapterBench().configured(0x843E, 63, 0, 500)
    bench.give(*move(20_000, 5000, 100, 100), ms=500)
    _, frames = said(bench, (4,), 300)
    assert frames == ["01 06 00 00 00 06 09 c8", "01 06 00 00 00 05 49 c9"]
    assert bench.bits == {"MODULE_OK", "HOLD_STATE"}


@pytest.mark.parametrize(
    ("kind", "frame"),
    [(AdapterBench, "01 06 00 00 00 05 49 c9"), (AdapterBench006, "a5 01 49 00 00 00 00 ef")],
    ids=["PCL601", "PMC006"],
)
def test_an_immediate_stop(kind, frame):
    bench = kind().configured()
    bench.give(*move(20_000, 5000, 100, 100), ms=500)
    _, frames = said(bench, (16,), 200)
    assert frames == [frame]
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
