"""Finds which rungs of an export with online edits the controller executes [1756-RM084, rung types].

A controller runs the original rungs until it tests the accepted edits (`TestEdits` of the program); pending
edits exist only in the programming software.
"""

from __future__ import annotations

from dataclasses import dataclass

NORMAL = "N"


@dataclass(frozen=True, slots=True)
class RungType:
    """A type of rung or text: its description, and when the controller executes it."""

    description: str
    runs: bool  # whether it is executed while the edits are not tested
    tested: bool  # whether it is executed while the edits are tested


RUNG_TYPES = {
    "N": RungType("a rung", runs=True, tested=True),
    "I": RungType("accepted, to be inserted", runs=False, tested=True),
    "D": RungType("accepted, to be deleted", runs=True, tested=False),
    "R": RungType("accepted, to be replaced", runs=True, tested=False),
    "IR": RungType("accepted, the replacement of the rung before it", runs=False, tested=True),
    "rN": RungType("a rung with a pending replacement", runs=True, tested=True),
    "rI": RungType("accepted, to be inserted, with a pending replacement", runs=False, tested=True),
    "rR": RungType("accepted, to be replaced, with a pending replacement", runs=True, tested=False),
    "e": RungType("a pending edit", runs=False, tested=False),
    "er": RungType("a pending replacement", runs=False, tested=False),
    "i": RungType("a pending insertion", runs=False, tested=False),
    "r": RungType("a rung with a pending replacement", runs=True, tested=True),
    "d": RungType("a rung to be deleted by a pending edit", runs=True, tested=True),
}
"""Rows by the Type of a rung; an `r` prefix means that a replacement of the rung is pending."""

ORIGINAL, PENDING, TESTED = "Original", "PendingEdits", "TestEdits"
TEXT_TYPES = {
    ORIGINAL: RungType("the original text", runs=True, tested=False),
    TESTED: RungType("the accepted text", runs=False, tested=True),
    PENDING: RungType("the pending text", runs=False, tested=False),
}
"""Rows by the OnlineEditType of structured text."""


@dataclass(frozen=True, slots=True)
class Edit:
    """A rung, or a version of structured text, in an online edit."""

    line: int  # in the file
    program: str
    routine: str
    rung: int | None  # number of the rung; None for structured text
    type: str  # its letters in the file
    says: str  # the description of its type
    runs: bool  # whether the controller executes it

    def __str__(self) -> str:
        rung = "" if self.rung is None else f" rung {self.rung}"
        verb = "runs" if self.runs else "does not run"
        return f"{self.program}.{self.routine}{rung} (line {self.line}): {self.type}, {self.says}; it {verb}"


def chosen_text(kinds: list[str], *, tested: bool) -> int:
    """Return the index of the structured text that the controller executes; 0 if it executes none.

    >>> chosen_text(["Original", "PendingEdits", "TestEdits"], tested=True)
    2
    """
    rows = [TEXT_TYPES.get(kind) for kind in kinds]
    runs = [row is not None and (row.tested if tested else row.runs) for row in rows]
    if True in runs:
        return runs.index(True)
    return kinds.index(ORIGINAL) if ORIGINAL in kinds else 0
