"""Options of a simulated PMC006x3s."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from scanrack.io_images.pmc006.instructions import INT32_MAX

from ...loop.module_options import Options

Number = Annotated[int, Field(ge=0, le=INT32_MAX)]


class Pmc006ControllerOptions(Options):
    """Versions of the hardware, and interpretations of the manual that a real device might contradict.

    Attributes:
        step_ack_value: data in the response to a successful step instruction; the manual's example shows 3
            without an explanation [4.3.1].
        i_signed: whether instruction i also accepts negative positions.
        max_microstep: 128 [4.3.2], or 256 as in the summary table [4.2].
        closed_loop: whether to simulate the closed-loop type E, which detects a stalled motor [2.3].
        device_id: response to instruction P.
        firmware: response to instruction R.
    """

    owner: ClassVar[str] = "simulated PMC006"

    step_ack_value: Number = 0
    i_signed: bool = False
    max_microstep: Literal[128, 256] = 128
    closed_loop: bool = False
    device_id: Number = 0
    firmware: Number = 0x0001_0000
