"""Random but plausible scripts, played on the module and on a plain oracle in lockstep.

The oracle (`oracle3601` and its neighbors in tests/support) is written from the manual: a loop over
250 µs ticks, floats for motion. It shares nothing with the module but the image and the names of bits.
Where both are right within the tolerance of floats but would part for good, a script is given up.

The search is told how rare the rules are that a script has made fire; with --long it tries more of its kind.
The end of a test run says which rules that were, see conftest.py.

Which of the manual's error rules a run of scripts has touched, how often, and which never.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterable
from textwrap import wrap

import pytest
from hypothesis import given, settings, target
from lockstep3601 import GivenUp, Lockstep
from scanrack.io_images.amci3601 import ERROR_BITS, RULES
from scanrack.io_images.amci3601.configuration import INVALID_CONFIGURATIONS
from stories3601 import CI_EXAMPLES, THEMES, scripts, scripts_of

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


PLAYED: set[str] = set()
"""Themes that have been played in this run of the tests."""

MORE = 5 * CI_EXAMPLES
"""Scripts per theme that are played if the profile's don't make every error rule fire."""


@pytest.fixture(scope="session")
def coverage(request):
    request.config.rule_coverage = RuleCoverage()
    return request.config.rule_coverage


@pytest.mark.costly("fewer scripts than these do not make every error rule fire")
@pytest.mark.parametrize("theme", THEMES)
def test_module_and_oracle_show_the_same_bits(theme, coverage):
    @settings(max_examples=max(CI_EXAMPLES, settings().max_examples))
    @given(script=scripts(theme))
    def lockstep(script):
        target(coverage.add(played(script)), label="rare rules")

    lockstep()
    PLAYED.add(theme)


def played(script):
    """Play a script in lockstep; return the module's events."""
    setting, steps = script
    bench = Lockstep(setting)
    with contextlib.suppress(GivenUp):
        for step in steps:
            step.play(bench)
    return bench.module.events


@pytest.mark.costly("plays the themes that its process has not played")
def test_every_error_rule_of_the_manual_has_fired(coverage):
    """All but those that `NEVER` gives a reason for.

    Themes that this process has not played (only some tests were chosen, or others run in another process)
    are played here. Two rules fire in two or six of the 540 scripts: where a change of the draw leaves one
    out, five times as many scripts are played.
    """
    for theme in set(THEMES) - PLAYED:
        play_scripts(theme, CI_EXAMPLES, coverage)
    for theme in THEMES if coverage.missing else ():
        play_scripts(theme, MORE, coverage)
    assert coverage.missing == []


def play_scripts(theme, examples, coverage):
    for script in scripts_of(theme, examples):
        coverage.add(played(script))


def test_themes_that_were_not_played_are_judged_all_the_same(monkeypatch):
    """Chosen alone, or in another process than those of the themes, the test above plays what is missing."""
    chosen = []
    first, *others = THEMES
    monkeypatch.setitem(globals(), "PLAYED", set(others))
    monkeypatch.setitem(globals(), "play_scripts", lambda theme, *_: chosen.append(theme))
    nothing_fired = RuleCoverage()
    with pytest.raises(AssertionError):
        test_every_error_rule_of_the_manual_has_fired(nothing_fired)
    assert chosen == [first, *THEMES]
