"""One command of an axis; it corresponds to a function block from a rising Execute to the end."""

from __future__ import annotations

from array import array
from enum import Enum
from typing import Protocol

from scanrack.io_images.image import Image
from typing_extensions import override

from ..sequences.watch import Watch
from .errors import AxisError, CommandAborted, ErrorId, reasons
from .kinds import CommandKind
from .link import LinkedWait


class Handshake(Protocol):
    """The part of a `Drive` that its commands use: the handshake with the module."""

    out: array[int]  # the eight words that are sent
    lsw: int  # status word 1
    trip_ns: int  # time for words to cross the backplane both ways
    parameters_first: bool  # whether the command bit follows the parameters a round trip later

    @property
    def under_way(self) -> bool:
        """Whether the module is executing the words of a command."""


class Outcome(Enum):
    """The outcome of a command."""

    BUSY = "busy"
    DONE = "done"
    ABORTED = "aborted"
    ERROR = "error"


class Command(LinkedWait[None]):
    """A requested command. You can await its end, or read its outcome.

    Args:
        axis: name of the axis.
        text: the call, as in "move_to(4000)".
    """

    __slots__ = ("_axis", "_is_active", "detail", "ended", "error_id", "kind", "outcome", "text", "words")

    attended = False
    """Whether `attend` is called in each scan."""

    handshake_over = True
    """Whether a handshake over several scans is complete."""

    def __init__(self, axis: str, kind: CommandKind, text: str) -> None:
        super().__init__()
        self._axis = axis
        self.kind = kind
        self.text = text
        self.words: array[int] = array("h")  # the eight words of the command; empty if it was refused
        self.outcome = Outcome.BUSY
        self.ended = False  # whether `outcome` is final
        self.error_id = ErrorId(0)  # the ErrorID of the function block; 0 without an error
        self.detail = ""  # details of the error
        self._is_active = False  # whether the words have been sent

    @property
    def busy(self) -> bool:
        """Whether the command is waiting or running."""
        return self.outcome is Outcome.BUSY

    @property
    def active(self) -> bool:
        """Whether its words have been sent and it has not ended."""
        return self._is_active and self.outcome is Outcome.BUSY

    @property
    def done(self) -> bool:
        """Whether it succeeded."""
        return self.outcome is Outcome.DONE

    @property
    def aborted(self) -> bool:
        """Whether another command has taken over the axis."""
        return self.outcome is Outcome.ABORTED

    @property
    def error(self) -> bool:
        """Whether it failed or was refused."""
        return self.outcome is Outcome.ERROR

    @override
    def watched(self) -> Watch:
        return Watch(flag=self)

    @override
    def poll(self, now_ns: int) -> bool:
        return self.outcome is not Outcome.BUSY

    @override
    def result(self) -> None:
        """Raise an AxisError if it failed, or CommandAborted if another command took over the axis."""
        if self.outcome is Outcome.ERROR:
            raise AxisError(f"{self!r}: {reasons(self.error_id, self.detail)}", self.error_id)
        if self.outcome is Outcome.ABORTED:
            raise CommandAborted(f"{self!r}: another command has taken the axis")

    @property
    @override
    def call(self) -> str:
        return f"{self._axis}.{self.text}"

    # -- for the drive

    def set_words(self, image: Image) -> None:
        """Set the words that start it."""
        self.words = array("h", image.words)

    def attend(self, drive: Handshake, now_ns: int) -> None:
        """Do the work of this command in each scan while it is executing."""

    def activate(self, now_ns: int) -> None:
        """Mark it as active, because its words are sent in this scan."""
        self._is_active = True

    def end(self, outcome: Outcome, error_id: int = 0, detail: str = "") -> None:
        """End it, unless it has ended."""
        if self.outcome is Outcome.BUSY:
            self.outcome, self.error_id, self.detail = outcome, ErrorId(error_id), detail
            self.ended = True
