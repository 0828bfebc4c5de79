"""Commands that keep running at a speed or act in each scan: velocity, registration, gear, home."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from scanrack.io_images.amci3601.bits import CommandLsw, StatusLsw
from typing_extensions import override

from .command import Command, Handshake
from .kinds import GEAR, HOME, REGISTRATION, VELOCITY

if TYPE_CHECKING:
    from .drive import Drive

_PROXIMITY = CommandLsw.HOME_PROXIMITY.value
_FOLLOWING = StatusLsw.ENC_FOLLOWER.value


class Velocity(Command):
    """A run at a speed until another command; its await then raises `CommandAborted`."""

    __slots__ = ("_drive", "_since_ns")

    def __init__(self, axis: str, text: str, drive: Drive) -> None:
        super().__init__(axis, VELOCITY, text)
        self._drive = drive
        self._since_ns: int | None = None

    @override
    def activate(self, now_ns: int) -> None:
        super().activate(now_ns)
        self._since_ns = now_ns

    @property
    def in_velocity(self) -> bool:
        """Whether the axis runs at constant speed, once the module has had time to begin a ramp."""
        return self.active and self._since_ns is not None and self._drive.runs_evenly(self._since_ns)


class Registration(Command):
    """A run at a speed that stops a set distance after the external input or `register`."""

    __slots__ = ("_registered",)

    attended = True

    def __init__(self, axis: str, text: str) -> None:
        super().__init__(axis, REGISTRATION, text)
        self._registered = False

    def register(self) -> None:
        """Act as if the external input had risen."""
        self._registered = True

    @override
    def attend(self, drive: Handshake, now_ns: int) -> None:
        if self._registered and drive.under_way:
            drive.out[0] = 0


class Gear(Command):
    """Gearing to the encoder, until another command; its await then raises `CommandAborted`."""

    __slots__ = ("_drive",)

    def __init__(self, axis: str, text: str, drive: Drive) -> None:
        super().__init__(axis, GEAR, text)
        self._drive = drive

    @property
    def in_gear(self) -> bool:
        """Whether the axis is following the encoder."""
        return self.active and self._drive.lsw & _FOLLOWING != 0


class Homing(Command):
    """Homing. In each scan, the backplane proximity bit follows the program's value."""

    __slots__ = ("_proximity", "attended")

    def __init__(self, axis: str, text: str, proximity: Callable[[], object] | None) -> None:
        super().__init__(axis, HOME, text)
        self._proximity = proximity
        self.attended = proximity is not None

    @override
    def attend(self, drive: Handshake, now_ns: int) -> None:
        if self._proximity is not None:
            drive.out[1] = drive.out[1] | _PROXIMITY if self._proximity() else drive.out[1] & ~_PROXIMITY
