"""What is chosen about a simulated PMC006x3s when it is made."""

from __future__ import annotations

from dataclasses import dataclass

from ....io_images.pmc006.instructions import INT32_MAX


@dataclass(frozen=True, slots=True)
class Pmc006Switches:
    """Versions of the hardware, and readings of the manual that can be switched.

    Attributes:
        step_ack_value: data of the reply to a successful step instruction; the manual's example shows 3,
            which it does not explain [4.3.1].
        i_signed: whether instruction i takes negative positions, too.
        max_microstep: 128 [4.3.2], or 256 as in the summary table [4.2].
        closed_loop: the closed-loop type E, which notices a stalled motor [2.3].
        device_id: what instruction P reads.
        firmware: what instruction R reads.

    Raises:
        ValueError: a value that is not allowed.
    """

    step_ack_value: int = 0
    i_signed: bool = False
    max_microstep: int = 128
    closed_loop: bool = False
    device_id: int = 0
    firmware: int = 0x0001_0000

    def __post_init__(self) -> None:
        if self.max_microstep not in (128, 256):
            raise ValueError(f"max_microstep {self.max_microstep}: allowed are 128 and 256")
        for name in ("step_ack_value", "device_id", "firmware"):
            if not 0 <= getattr(self, name) <= INT32_MAX:
                raise ValueError(f"{name} {getattr(self, name)}: allowed is 0 to {INT32_MAX}")
