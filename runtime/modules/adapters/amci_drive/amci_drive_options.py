"""Options of the adapter for a networked drive."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.models import MODELS, SMD23E2, Model

from ....loop.module_options import Options

InputName = Literal["none", "capture", "external", "home", "estop", "cw_limit", "ccw_limit"]

LIMITS = SMD23E2.limits


class AmciDriveOptions(Options):
    """Substitutions, and the drive's wiring and motor.

    Attributes:
        model: model of the drive.
        axis: number of the drive in a stack, 1 to 12.
        in1: input of the 3601 that is wired to input 1.
        in2: input of the 3601 that is wired to input 2.
        unwired: what to do if the configuration uses inputs that are not wired: "inactive" reads them as
            inactive, "reject" refuses the configuration.
        rpi_ms: time between exchanges, ms, 1 to 100; a response after this time is late.
        strict: whether to refuse S-curves that none of the drive's jerks matches exactly.
        diagnostic: "mirror" copies the position to the diagnostic words; "reject" refuses diagnostic
            feedback.
        encoder_move: "polled" ends an encoder move when the count that is read reaches the target; "refuse"
            refuses the move.
        steps_per_turn: motor steps per turn, 200 to 32,767.
        counts_per_turn: x4 counts per turn of the encoder.
        current: motor current, 0.1 A.
        idle_percent: current at rest, % of `current`.
    """

    owner: ClassVar[str] = "adapter of a networked drive"

    model: Literal["smd23e2", "smd24e2"] = "smd23e2"
    axis: Annotated[int, Field(ge=1, le=12)] = 1
    in1: InputName = "home"
    in2: InputName = "cw_limit"
    unwired: Literal["reject", "inactive"] = "reject"
    rpi_ms: Annotated[int, Field(ge=1, le=100)] = 8
    strict: bool = False
    diagnostic: Literal["reject", "mirror"] = "reject"
    encoder_move: Literal["refuse", "polled"] = "refuse"
    steps_per_turn: Annotated[int, Field(ge=LIMITS.steps_per_turn[0], le=LIMITS.steps_per_turn[1])] = 2000
    counts_per_turn: Annotated[int, Field(ge=0, le=LIMITS.counts_per_turn)] = 2048
    current: Annotated[int, Field(ge=LIMITS.current[0], le=LIMITS.current[1])] = 30
    idle_percent: Annotated[int, Field(ge=0, le=LIMITS.idle_percent)] = 50

    @property
    def row(self) -> Model:
        """The model's row in the table of models."""
        return MODELS[self.model]

    @property
    def wired(self) -> tuple[int, int]:
        """The inputs of the 3601 that are wired to inputs 1 and 2, as masks; 0 for none."""
        return _mask(self.in1), _mask(self.in2)


def _mask(name: InputName) -> int:
    return 0 if name == "none" else InputBit[name.upper()].value
