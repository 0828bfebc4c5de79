"""Which of the manual's error rules a run of scripts has touched, how often, and which never."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from textwrap import wrap

from scanrack.io_images.amci3601 import ERROR_BITS, RULES
from scanrack.io_images.amci3601.configuration import INVALID_CONFIGURATIONS

LISTED = tuple(
    rule.id for rule in RULES.values() if rule.list_of is not None and rule.list_of & ERROR_BITS.value
)
"""The rows of chapter 6's lists of errors."""

ERROR_RULES = (*(rule for rule, _ in INVALID_CONFIGURATIONS), *LISTED)
"""Every error that the manual lists: of configurations [chapter 3], of everything else [chapter 6]."""

NEVER = {rule: RULES[rule].untestable_because for rule in ERROR_RULES if RULES[rule].untestable_because}
"""Error rules that no run can reach, and why."""


class RuleCoverage:
    """Counts in how many scripts each rule has fired."""

    def __init__(self) -> None:
        self.fired: Counter[str] = Counter()
        self.scripts = 0

    def add(self, events: Iterable) -> float:
        """Count a script's events; return how rare its rules were up to now, 0 for rules seen often."""
        rules = sorted({event.name for event in events if event.kind == "rule"})
        rarity = sum(1 / (1 + self.fired[rule]) for rule in rules)
        self.fired.update(rules)
        self.scripts += 1
        return rarity

    @property
    def missing(self) -> list[str]:
        """Error rules that could have fired and have not."""
        return [rule for rule in ERROR_RULES if not self.fired[rule] and rule not in NEVER]

    def lines(self) -> list[str]:
        """The report: what fired, the rarest first, and what did not."""
        reached = [rule for rule in ERROR_RULES if self.fired[rule]]
        rarest = sorted(reached, key=lambda rule: self.fired[rule])
        told = ", ".join(f"{rule} {self.fired[rule]}" for rule in rarest)
        lines = [f"{len(reached)} of {len(ERROR_RULES)} error rules fired in {self.scripts:,} scripts"]
        lines += wrap(told, 100, initial_indent="  scripts  ", subsequent_indent=" " * 11)
        lines += wrap(", ".join(self.missing), 100, initial_indent="  never    ", subsequent_indent=" " * 11)
        return lines + [f"  {rule}: cannot fire: {why}" for rule, why in NEVER.items()]
