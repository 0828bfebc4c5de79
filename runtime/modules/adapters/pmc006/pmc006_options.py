"""Options of the PMC006 adapter."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator
from scanrack.io_images.pmc006.instructions import BY_NAME, InstructionRow

from ....loop.module_options import Options


def _accepted_by(row: InstructionRow) -> BeforeValidator:
    """Return a validator that accepts None and the numbers that an instruction accepts."""

    def check(value: object) -> object:
        if value is not None and (type(value) is not int or not row.allows(value)):
            raise ValueError(f"{value!r} is not allowed: {row.allowed} {row.unit}")
        return value

    return BeforeValidator(check)


class Pmc006Options(Options):
    """Substitutions and wiring of the device.

    Attributes:
        home_stroke: longest homing travel, steps; without it, every configuration is refused.
        strict: refuse motions whose ramp would be slower than programmed or have a different shape.
        blend: "segmented" runs the segments of a blend move one by one, with a stop between them; "refuse"
            refuses blend moves.
        capture: "fset" wires the capture input to FSET; "reject" refuses the capture input.
        registration: "polled" stops a registration move after a read of its input, then makes the remaining
            steps; "refuse" refuses it.
        accel_rounding: rate of the device's table: "gentler" than programmed, or the "nearest", which may
            be steeper.
        hold: "immediate" holds a move without a ramp, and allows the external input on FSET; "refuse" refuses
            both.
        respeed: "restart" stops a manual move to change its speed; "refuse" refuses the change.
        peak_current: phase current of the motor, mA; by default the current saved in the device.
        diagnostic: "mirror" copies the position to the diagnostic words; "reject" refuses diagnostic
            feedback.
    """

    owner: ClassVar[str] = "PMC006 adapter"

    home_stroke: Annotated[int | None, _accepted_by(BY_NAME["zero_back"])] = None
    strict: bool = False
    blend: Literal["refuse", "segmented"] = "refuse"
    capture: Literal["reject", "fset"] = "reject"
    registration: Literal["refuse", "polled"] = "refuse"
    accel_rounding: Literal["gentler", "nearest"] = "gentler"
    hold: Literal["refuse", "immediate"] = "refuse"
    respeed: Literal["refuse", "restart"] = "refuse"
    peak_current: Annotated[int | None, _accepted_by(BY_NAME["peak_current"])] = None
    diagnostic: Literal["reject", "mirror"] = "reject"
