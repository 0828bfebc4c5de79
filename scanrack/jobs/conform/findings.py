"""The result of a judged plan: verdicts on scenes, rules and interpretations."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from .moments import ImageWords
from .rules_apart.scales import FittedScale


class ConformVerdict(StrEnum):
    """Of a rule, a reading or a scene."""

    AS_MANUAL = "as the manual"
    DIFFERS = "differs"
    OPEN = "open"
    NOT_IN_PLAN = "not in this plan"


UNDECIDED = (ConformVerdict.OPEN, ConformVerdict.NOT_IN_PLAN)
"""Verdicts that a later scene may replace."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A read that no hypothesis explains.

    Attributes:
        at_ns: since what was sent last.
        sent: the words that were sent last.
        read: the words that were read.
        shown: the earliest and the latest words that the best hypothesis shows in its window.
    """

    at_ns: int
    sent: ImageWords
    read: ImageWords
    shown: tuple[ImageWords, ImageWords]


@dataclass(slots=True)
class SceneVerdict:
    """The verdict on a scene.

    Attributes:
        reads: reads that were judged.
        hypotheses: largest number of them at a time.
        why: the reason, if it is open.
        readings: readings whose rival alone explains it.
        rules: rules without which a module explains it.
        scales: factors with which a module explains it.
    """

    name: str
    verdict: ConformVerdict
    reads: int
    hypotheses: int
    why: str = ""
    difference: Difference | None = None
    readings: list[str] = field(default_factory=list)
    rules: list[str] = field(default_factory=list)
    scales: list[FittedScale] = field(default_factory=list)


@dataclass(slots=True)
class RuleFinding:
    """A verdict on a rule or a reading.

    Attributes:
        scene: that settles it; "" if none does.
        why: what speaks for it, or why it is open.
    """

    verdict: ConformVerdict
    scene: str = ""
    why: str = ""


@dataclass(slots=True)
class ConformResult:
    """All verdicts."""

    scenes: list[SceneVerdict] = field(default_factory=list)
    rules: dict[str, RuleFinding] = field(default_factory=dict)
    readings: dict[str, RuleFinding] = field(default_factory=dict)

    @property
    def differs(self) -> bool:
        """Whether some scene differs."""
        return any(each.verdict is ConformVerdict.DIFFERS for each in self.scenes)
