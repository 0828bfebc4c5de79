"""A machine that can't be built is refused: field, value and what is allowed are named."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import (
    EncoderSpec,
    Jam,
    MachineSpec,
    Slip,
    Station,
    Switch,
    TimelineEntry,
    press,
)

HOME, ESTOP, EXTERNAL = InputBit.HOME, InputBit.ESTOP, InputBit.EXTERNAL


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Switch(4, 0, 1), r"Switch\.input is 4; allowed: one of CAPTURE, EXTERNAL, HOME"),  # type: ignore[arg-type]
        (lambda: Switch(HOME | ESTOP, 0, 1), r"Switch\.input is .*12.*; allowed: one of"),
        (lambda: Switch(HOME, 1.5, 2), r"Switch\.first is 1\.5; allowed: a whole number"),  # type: ignore[arg-type]
        (lambda: Switch(HOME, 0, True), r"Switch\.last is True; allowed: a whole number"),
        (lambda: Switch(HOME, 3500, 3000), r"Switch\.last is 3000; allowed: 3500 \(first\) or more, or None"),
        (lambda: Switch(HOME, 0, 1, "nc"), r"Switch\.normally_closed is 'nc'; allowed: False, True"),  # type: ignore[arg-type]
        (lambda: TimelineEntry(-1, HOME, True), r"TimelineEntry\.at_ns is -1; .* 0 or more"),
        (lambda: TimelineEntry(0, None, True), r"TimelineEntry\.input is None"),  # type: ignore[arg-type]
        (lambda: TimelineEntry(0, HOME, 1), r"TimelineEntry\.energized is 1; allowed: True, False, None"),  # type: ignore[arg-type]
        (lambda: press(5, HOME, 0), r"press: for_ns 0: must be 1 or more"),
        (lambda: EncoderSpec(0), r"EncoderSpec\.counts_per_step is 0; allowed: .* more than 0"),  # type: ignore[arg-type]
        (lambda: EncoderSpec(0.5), r"EncoderSpec\.counts_per_step is 0\.5; allowed: a Fraction"),  # type: ignore[arg-type]
        (lambda: EncoderSpec(Fraction(-1, 2)), r"EncoderSpec\.counts_per_step is Fraction\(-1, 2\)"),
        (lambda: EncoderSpec(Fraction(1), 0), r"EncoderSpec\.direction is 0; allowed: 1, -1"),
        (lambda: EncoderSpec(Fraction(1), 1, 0), r"EncoderSpec\.marker_every is 0; .* 1 or more"),
        (
            lambda: EncoderSpec(Fraction(1), 1, 10, None),  # type: ignore[arg-type]
            r"EncoderSpec\.marker_at is None; allowed: a whole number",
        ),
        (lambda: Slip(None, 1), r"Slip\.at is None"),  # type: ignore[arg-type]
        (lambda: Slip(0, 0), r"Slip\.steps is 0; allowed: a whole number, 1 or more"),
        (lambda: Slip(0, 1, 2), r"Slip\.direction is 2; allowed: 1, -1, 0"),
        (lambda: Slip(0, 1, True), r"Slip\.direction is True"),
        (lambda: Slip(0, 1, times=0), r"Slip\.times is 0; .* 1 or more"),
        (lambda: Slip(0, 1, chance=1.01), r"Slip\.chance is 1\.01; allowed: a number from 0 to 1"),
        (lambda: Slip(0, 1, chance=float("nan")), r"Slip\.chance is nan"),
        (lambda: Jam(0.0, 1), r"Jam\.at is 0\.0"),  # type: ignore[arg-type]
        (lambda: Jam(0, 0), r"Jam\.direction is 0; allowed: 1, -1"),
        (lambda: Station(0, HOME, -1, 1), r"Station\.work_ns is -1; .* 0 or more"),
        (lambda: Station(0, HOME, 0, 0), r"Station\.pulse_ns is 0; .* 1 or more"),
        (lambda: Station("0", HOME, 0, 1), r"Station\.position is '0'"),  # type: ignore[arg-type]
    ],
)
def test_a_part_that_cannot_be(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"switches": 5}, r"MachineSpec\.switches is 5; allowed: a sequence of Switch"),
        ({"jams": [Slip(0, 1)]}, r"MachineSpec\.jams is Slip\(.*; allowed: Jam only"),
        ({"encoder": Fraction(1)}, r"MachineSpec\.encoder is .*; allowed: an EncoderSpec or None"),
        (
            {"switches": [Switch(HOME, 0, 1), Switch(HOME, 5, 6, True)]},
            r"MachineSpec\.switches is 'HOME'; allowed: normally open or normally closed",
        ),
        (
            {"switches": [Switch(HOME, 0, 1)], "stations": [Station(0, HOME, 0, 1)]},
            r"MachineSpec\.stations is Station\(.*; allowed: an input without a switch",
        ),
        (
            {"timeline": [TimelineEntry(7, EXTERNAL, None)]},
            r"MachineSpec\.timeline is TimelineEntry\(at_ns=7.*; allowed: energized None on inputs with",
        ),
    ],
)
def test_parts_that_do_not_go_together(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        MachineSpec(**fields)


def test_lists_become_tuples_and_a_whole_ratio_a_fraction() -> None:
    spec = MachineSpec(switches=[Switch(HOME, 0, None)], encoder=EncoderSpec(4))  # type: ignore[arg-type]
    assert spec.switches == (Switch(HOME, 0, None),)
    assert spec.encoder == EncoderSpec(Fraction(4))
    assert isinstance(hash(spec), int)


def test_press_of_a_normally_closed_button_opens_it() -> None:
    pressed, released = press(100, ESTOP, 30, normally_closed=True)
    assert (pressed, released) == (TimelineEntry(100, ESTOP, False), TimelineEntry(130, ESTOP, True))
