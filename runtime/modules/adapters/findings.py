"""Findings of a driver about its device, which the adapter converts to the 3601's bits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, auto


class FindingKind(IntEnum):
    """Kinds of findings, in the order in which they are processed."""

    POWER_LOST = auto()
    """The device was switched off."""
    COMPLAINT = auto()
    """The device has reported an error, or has not obeyed."""
    RETURNED = auto()
    """The device answers again after a loss of the link, and was not switched off."""
    STRAYED = auto()
    """The axis has moved without a command."""
    OUT_OF_RANGE = auto()
    """A slew has reached the end of the counter's range."""
    STOPPED_SHORT = auto()
    """A motion has ended before its target."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding."""

    kind: FindingKind
    bits: int = 0  # for a complaint: its bits of input word 0
    text: str = ""  # for a complaint: the reason


class Findings:
    """Findings that the adapter has not processed yet."""

    def __init__(self) -> None:
        self._waiting: list[Finding] = []

    def add(self, kind: FindingKind) -> None:
        """Add a finding, unless a finding of its kind is waiting."""
        finding = Finding(kind)
        if finding not in self._waiting:
            self._waiting.append(finding)

    def complain(self, bits: int, text: str) -> None:
        """Add a complaint, with the bits of input word 0 that report it."""
        self._waiting.append(Finding(FindingKind.COMPLAINT, bits, text))

    def take(self) -> list[Finding]:
        """Return and remove all findings, sorted by kind and then by time."""
        findings, self._waiting = sorted(self._waiting, key=lambda finding: finding.kind), []
        return findings
