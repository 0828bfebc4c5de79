"""What a driver finds out about its controller, for the adapter to turn into the 3601's bits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, auto


class FindingKind(IntEnum):
    """Kinds of findings, in the order in which an adapter takes notice of them."""

    POWER_LOST = auto()
    """The controller was switched off meanwhile."""
    COMPLAINT = auto()
    """The controller reports an error, or does not obey."""
    RETURNED = auto()
    """The controller answers again after a loss, and was not switched off."""
    STRAYED = auto()
    """The axis has moved without a command."""
    OUT_OF_RANGE = auto()
    """A slew has come to the end of the counter's range."""
    STOPPED_SHORT = auto()
    """A motion has ended before its target."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing found out.

    Attributes:
        bits: of a complaint: bits of input word 0 that it sets.
        text: of a complaint: the reason.
    """

    kind: FindingKind
    bits: int = 0
    text: str = ""


class Findings:
    """Findings that the adapter has not taken yet."""

    def __init__(self) -> None:
        self._waiting: list[Finding] = []

    def add(self, kind: FindingKind) -> None:
        """Note a finding; one of its kind that waits already says the same."""
        finding = Finding(kind)
        if finding not in self._waiting:
            self._waiting.append(finding)

    def complain(self, bits: int, text: str) -> None:
        """Note a complaint, with the bits of input word 0 that it sets."""
        self._waiting.append(Finding(FindingKind.COMPLAINT, bits, text))

    def take(self) -> list[Finding]:
        """Return all findings, by kind and then in order of time, and forget them."""
        taken, self._waiting = sorted(self._waiting, key=lambda each: each.kind), []
        return taken
