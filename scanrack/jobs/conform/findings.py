"""The result of judging a plan: verdicts on scenes, rules and readings."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from .moments import ImageWords
from .rules_apart.scales import FittedScale


class ConformVerdict(StrEnum):
    """The verdict on a rule, a reading or a scene."""

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
        at_ns: time since words were last sent, ns.
        sent: the words that were sent last.
        read: the words that were read.
        shown: the earliest and latest words that the best hypothesis shows in the window of the read.
    """

    at_ns: int
    sent: ImageWords
    read: ImageWords
    shown: tuple[ImageWords, ImageWords]


@dataclass(slots=True)
class SceneVerdict:
    """The verdict on a scene.

    Attributes:
        reads: number of reads that were judged.
        hypotheses: largest number of hypotheses at a time.
        why: the reason if the verdict is open.
        readings: readings for which a rival explains the scene.
        rules: rules for which a module without the rule explains the scene.
        scales: factors that let a module explain the scene.
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
        scene: the scene that settles it; "" if none does.
        why: the evidence, or the reason why the verdict is open.
    """

    verdict: ConformVerdict
    scene: str = ""
    why: str = ""


@dataclass(slots=True)
class ConformResult:
    """All verdicts on a plan."""

    scenes: list[SceneVerdict] = field(default_factory=list)
    rules: dict[str, RuleFinding] = field(default_factory=dict)
    readings: dict[str, RuleFinding] = field(default_factory=dict)

    @property
    def differs(self) -> bool:
        """Whether any scene differs from the manual."""
        return any(scene.verdict is ConformVerdict.DIFFERS for scene in self.scenes)
