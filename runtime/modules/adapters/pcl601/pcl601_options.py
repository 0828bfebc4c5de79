"""Options of the PCL601 adapter."""

from __future__ import annotations

from typing import ClassVar, Literal

from ....loop.module_options import Options


class Pcl601Options(Options):
    """Substitutions and wiring of the controller.

    Attributes:
        strict: refuse motions with a slower ramp than programmed.
        blend: "segmented" runs the segments of a blend move one by one, with a stop in between; else
            refused.
        capture: "polled", within a poll period of the edge, or "reject".
        diagnostic: "mirror" copies the position to the diagnostic words, "reject" refuses them.
        limit_sense: "inputs": the end limits are wired to inputs 1 and 5, too; else to the hard limits only.
        proximity: "jumper": output 6 is wired to both soft limits, and is the backplane home proximity;
            else that is refused.
        registration: "jumper": input 2 is wired to output 7 alone; "polled": to nothing, and a registration
            move stops after a read of its input, then makes the remaining steps; else it is
            wired to output 7 and the external input.
        encoder_move: "polled" ends an encoder move after a read of the count; else refused.
        respeed: "restart" changes the speed of a manual move by a stop in between; else refused.
        takeover: prevent the controller's own program from starting at power-up: clear its autorun flag,
            which is non-volatile.
    """

    owner: ClassVar[str] = "PCL601 adapter"

    strict: bool = False
    blend: Literal["refuse", "segmented"] = "refuse"
    capture: Literal["polled", "reject"] = "polled"
    diagnostic: Literal["reject", "mirror"] = "reject"
    limit_sense: Literal["hard_limits", "inputs"] = "hard_limits"
    proximity: Literal["reject", "jumper"] = "reject"
    registration: Literal["default", "jumper", "polled"] = "default"
    encoder_move: Literal["refuse", "polled"] = "refuse"
    respeed: Literal["refuse", "restart"] = "refuse"
    takeover: bool = False
