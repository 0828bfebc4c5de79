"""Errors in a program's text and logic, and the faults of a scan."""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import NOWHERE, Site, SiteError


class LadderError(SiteError):
    """A program that can't be read or built."""


class RungTextError(LadderError):
    """An error in rung text, with the file, rung, line, column and the expected text."""

    def __init__(self, expected: str, found: str, site: Site) -> None:
        self.expected = expected
        reason = f"expected {expected}, found {found}"
        of_rung = "" if site.rung is None else f"rung {site.rung}, "
        super().__init__(f"{site.spot}: {of_rung}column {site.column}: {reason}", site)
        self.reason = reason


@dataclass(frozen=True, slots=True)
class Problem:
    """A reason why a program can't be built."""

    where: str  # routine and rung, or the tag, as shown to the user
    rung: str  # the rung as text, "" if it is not a rung
    text: str  # the error, with the wrong and the allowed values
    remedy: str
    site: Site = NOWHERE  # its `rung` is unset if the problem is not in a rung
    rule: str = ""  # for a warning, the rule of `scanrack check`

    def __str__(self) -> str:
        shown = f"\n    {self.rung}" if self.rung else ""
        return f"{self.where}: {self.text}; {self.remedy}{shown}"


class BuildError(LadderError):
    """The build of a program failed. The message lists every problem with its rung and a remedy."""

    def __init__(self, name: str, problems: Sequence[Problem], kind: str = "program") -> None:
        self.problems = tuple(problems)
        text = "\n".join([f"{kind} {name} can't be built:", *map(str, problems)])
        super().__init__(text, *(problem.site for problem in problems))


class LadderFault(Exception):  # noqa: N818 - the term in manuals
    """A major fault: the scan stops."""

    def __init__(self, site: Site, tag: str, text: str, code: int, kind: int = 4) -> None:
        self.site, self.tag, self.text, self.type, self.code = site, tag, text, kind, code
        self.calls: tuple[Site, ...] = ()
        self.tags: tuple[str, ...] = ()  # the tags in the condition of an ASSERT
        super().__init__(f"{site}: {tag}: {text} (major fault, type {self.type} code {code})")

    def called_by(self, site: Site) -> None:
        """Record the add-on call in which the fault occurred."""
        self.calls += (site,)

    def __str__(self) -> str:
        calls = "".join(f"; called by {call.call}" for call in self.calls)
        return f"{super().__str__()}{calls}"


SUBSCRIPT_CODE = 20
"""Subscript too large or negative [1756-PM014, major fault codes]."""

CONTROL_CODE = 21
"""LEN or POS of a CONTROL is negative [1756-PM014, major fault codes]."""

ASSERTION_CODE = 990
"""A condition of ASSERT is false; codes 990 to 999 are user-defined [1756-PM014, major fault codes]."""

TIMER_CODE = 34
"""PRE or ACC of a timer is negative [1756-RM003N p. 117]."""

STACK_CODE = 84
"""Stack overflow: subroutine calls are nested too deeply [1756-PM014, major fault codes]."""

WATCHDOG_TYPE, WATCHDOG_CODE = 6, 1
"""The task's watchdog has expired [1756-PM014, major fault codes]."""

STRING_CODE = 51
"""Minor: LEN of a string, or of the result, exceeds the size of DATA [1756-RM003N p. 610]."""

SHORT_STRING_CODE = 52
"""Minor: the destination is too short for the string of a number [1756-RM003N p. 629]."""

STRING_NUMBER_CODE = 53
"""Minor: the number in a string does not fit its destination [1756-RM003N p. 623]."""

STRING_PLACE_CODE = 56
"""Minor: a start position or quantity is outside a string [1756-RM003N p. 614, 618]."""

PID_TIME_CODE, PID_SETPOINT_CODE = 35, 36
"""Minor: the update time of a PID is not above 0, or its setpoint is out of range [1756-PM014]."""

OVERFLOW_CODE = 4
"""Minor: overflow, or a divisor of zero [1756-RM003N p. 277]."""


class TooLongError(LadderError):
    """A routine that compiles to too much Python."""

    def __init__(self, reason: str, remedy: str, site: Site) -> None:
        super().__init__(f"{reason}: {remedy}", site)
        self.reason, self.remedy = reason, remedy


class OutOfLinesError(Exception):
    """The limit on executed rungs and statements has been reached; see `Interpreter.lines_left`."""


class ScanEndedError(Exception):
    """TND of an SLC 500 ends the scan, in any routine."""


@dataclass(frozen=True, slots=True)
class MinorFault:
    """A minor fault. It is recorded, and the scan continues."""

    site: Site
    now_ns: int
    text: str
    type: int = 4
    code: int = OVERFLOW_CODE

    def __str__(self) -> str:
        return f"{self.site}: {self.text} (minor fault, type {self.type} code {self.code})"
