"""Random but plausible scripts, played on the module and on a plain oracle in lockstep.

The oracle (`oracle3601` and its neighbors in tests/support) is written from the manual: a loop over
250 µs ticks, floats for motion. It shares nothing with the module but the image and the names of bits.
Where both are right within the tolerance of floats but would part for good, a script is given up.

The search is told how rare the rules are that a script has made fire; with --long it tries more of its kind.
The end of a test run says which rules that were, see conftest.py.
"""

from __future__ import annotations

import contextlib

import pytest
from coverage3601 import RuleCoverage
from hypothesis import given, settings, target
from lockstep3601 import GivenUp, Lockstep
from stories3601 import CI_EXAMPLES, THEMES, scripts, scripts_of

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
    """All but those that `coverage3601.NEVER` gives a reason for.

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
