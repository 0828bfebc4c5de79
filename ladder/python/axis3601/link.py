"""The link to a module: whether its images are being exchanged, and when that changed."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

from scanrack.io_images.times import seconds
from typing_extensions import override

from ..sequences.parts import Slot
from ..sequences.waits import Wait

T_co = TypeVar("T_co", covariant=True)


class _Faults:
    """The link of a slot, with the attribute `linked` of a module."""

    def __init__(self, slot: Any) -> None:
        self._slot = slot

    @property
    def linked(self) -> bool:
        return not getattr(self._slot, "fault", 0)


class Link:
    """The link to a module, from its connection fault [`I.Fault` of a CompactLogix].

    Args:
        number: number of the slot.
        slot: the slot with an attribute `fault`; without this attribute the module always answers.

    Attributes:
        module: an object whose attribute `linked` says whether the module answers; if possible, from the
            slot.
    """

    def __init__(self, number: int = 0, slot: Slot | None = None) -> None:
        self.number = number
        self.down = False  # whether the PLC does not reach the module
        self.changes = 0  # number of losses and returns
        self.lost_ns = 0  # time of the last loss, ns
        self.back_ns = 0  # time of the last return, ns
        module = getattr(slot, "module", None)
        self.module: Any = module if hasattr(module, "linked") else _Faults(slot)

    def update(self, now_ns: int) -> bool:
        """Read the connection fault; return whether it has changed."""
        down = not self.module.linked
        if down is self.down:
            return False
        self.down = down
        self.changes += 1
        if down:
            self.lost_ns = now_ns
        else:
            self.back_ns = now_ns
        return True

    def __str__(self) -> str:
        """Describe the last loss."""
        lost = f"the link to slot {self.number} was lost at {seconds(self.lost_ns)} s"
        return lost if self.down else f"{lost} and came back at {seconds(self.back_ns)} s"


class LinkedWait(Wait[T_co], Generic[T_co]):
    """A wait for a module; its text mentions a lost link."""

    __slots__ = ("_link",)

    def __init__(self) -> None:
        self.follow(Link())

    def follow(self, link: Link) -> None:
        """Set the link."""
        self._link = link

    @property
    @override
    def moved(self) -> int:
        """Number of times the link went down or came back; each one changes the text."""
        return self._link.changes

    def __repr__(self) -> str:
        call = self.call
        return f"{call} ({self._link})" if self._link.down else call

    @property
    def call(self) -> str:
        """The call that created it, as text."""
        raise NotImplementedError(f"{type(self).__name__} has no call")
