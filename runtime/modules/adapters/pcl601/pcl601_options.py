"""Options of the PCL601 adapter."""

from __future__ import annotations

from typing import ClassVar, Literal

from ....loop.module_options import Options


class Pcl601Options(Options):
    """Substitutions and wiring of the device.

    Attributes:
        strict: refuse motions whose ramp would be slower than programmed.
        blend: "segmented" runs the segments of a blend move one by one, with a stop between them; "refuse"
            refuses blend moves.
        capture: "polled" captures within a poll period of the edge; "reject" refuses the capture input.
        diagnostic: "mirror" copies the position to the diagnostic words; "reject" refuses diagnostic
            feedback.
        limit_sense: "hard_limits" wires the end limits to the hard limits only; "inputs" also wires them to
            inputs 1 and 5.
        proximity: "jumper" wires output 6 to both soft limits, as the backplane home proximity; "reject"
            refuses a configuration with that proximity.
        registration: wiring of input 2: "default" wires it to output 7 and the external input, "jumper" to
            output 7 only, and "polled" to nothing. A polled registration move stops after a read of its
            input, then makes the remaining steps.
        encoder_move: "polled" ends an encoder move after a read of the count; "refuse" refuses it.
        respeed: "restart" stops a manual move to change its speed; "refuse" refuses the change.
        takeover: clear the device's non-volatile autorun flag, so that its own program does not start at
            power-up.
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
