"""Claims about conditions of a program: never true, always true, reachable, or assumed.

    // prove: never Fwd AND Rev
    // prove: always NOT Valve OR Pump
    // prove: reachable Done
    // prove: assume NOT Maintenance

Claims are comments on rungs and on lines of structured text. Their names are resolved in the routine's
program. A rack file has the same kinds of claims in `[[prove.property]]`.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

from scanrack.io_images.site import NOWHERE, Site

from ..model.errors import LadderError
from ..model.tags import program_of
from ..state.lowered import LoweredLine, LoweredProgram, LoweredRoutine

NEVER = "NEVER"
"""Name, in upper or lower case, of a monitor routine, which no routine calls."""


class ClaimKind(StrEnum):
    """Kind of statement about a condition."""

    NEVER = "never"
    ALWAYS = "always"
    REACHABLE = "reachable"
    ASSUME = "assume"


@dataclass(frozen=True, slots=True)
class Claim:
    """A condition of structured text on the state after a scan; `old(Tag)` is the value before the scan."""

    name: str
    kind: ClaimKind
    text: str
    assume: tuple[str, ...] = ()  # conditions assumed in each scan, for this claim only
    scope: str = ""  # the program in which its names are resolved; "" for the controller
    site: Site = NOWHERE  # the rung with the comment, or the rung of a routine NEVER

    @property
    def sentence(self) -> str:
        """The claim as text, such as `never Fwd AND Rev`."""
        return f"{self.kind} {self.text}"


_CLAIM = re.compile(r"^\W*prove\s*:\s*(?P<kind>\S+)(?:\s+(?P<text>.*?))?[;\s]*$", re.IGNORECASE)
"""A claim in a comment line; marks such as `//` and `*` can precede it."""


def claims_in(lowered: LoweredProgram) -> list[Claim]:
    """Return the claims in the comments of a program, in the order of its routines and rungs.

    Raises:
        LadderError: a claim is unknown, has no condition, or is in an add-on instruction.
    """
    claims = []
    for routine in lowered.routines.values():
        for line in routine.lines:
            for kind, text in _read(line):
                claims.append(_checked_claim(lowered, routine, line, kind, text))
    return named_apart(claims)


def named_apart(claims: Iterable[Claim]) -> list[Claim]:
    """Return the claims with unique names; a number is added to a repeated name, such as `never Fwd (2)`.

    >>> claims = [Claim(name, ClaimKind.NEVER, "Fwd") for name in ("one way", "One way")]
    >>> [claim.name for claim in named_apart(claims)]
    ['one way', 'One way (2)']
    """
    counts: dict[str, int] = {}
    unique = []
    for claim in claims:
        number = counts[claim.name.upper()] = counts.get(claim.name.upper(), 0) + 1
        unique.append(claim if number == 1 else replace(claim, name=f"{claim.name} ({number})"))
    return unique


def _read(line: LoweredLine) -> Iterator[tuple[str, str]]:
    """Yield the kind and the condition of each claim in a comment."""
    for text in line.comment.splitlines():
        match = _CLAIM.match(text)
        if match:
            yield match["kind"], match["text"] or ""


def _checked_claim(
    lowered: LoweredProgram, routine: LoweredRoutine, line: LoweredLine, kind: str, text: str
) -> Claim:
    """Return the claim in a line's comment; raise a LadderError if it is not valid."""
    site = place_of_line(lowered, routine, line)
    if kind.lower() not in list(ClaimKind):
        close = difflib.get_close_matches(kind.lower(), list(ClaimKind), n=1)
        hint = f"did you mean {close[0]}" if close else f"claims are {', '.join(ClaimKind)}"
        raise LadderError(f"{site.where}: prove: {kind}: {hint}", site)
    if not text:
        raise LadderError(f"{site.where}: prove: {kind.lower()}: a condition is missing", site)
    if routine.frame:
        raise LadderError(
            f"{site.where}: prove: {kind.lower()} {text}: an add-on instruction has no claims; "
            "write it at a rung that calls it",
            site,
        )
    return Claim(
        f"{kind.lower()} {text}", ClaimKind(kind.lower()), text, scope=program_of(routine.name), site=site
    )


def place_of_line(lowered: LoweredProgram, routine: LoweredRoutine, line: LoweredLine) -> Site:
    """Return the site of a rung or a line."""
    program = program_of(routine.name) or lowered.name
    unit = "rung" if routine.body is None else "line"
    origin = line.origin
    return Site(program, routine.name, line.number, "", unit, file=origin.file, line=origin.line or None)
