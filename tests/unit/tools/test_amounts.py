"""How many examples a test with a number of its own gets, by the profile of tests/conftest.py."""

from __future__ import annotations

import amounts
import pytest
from hypothesis import settings


@pytest.mark.parametrize(("profile", "expected"), [("ci", 15), ("long", 1800)])
def test_a_number_of_examples_grows_with_the_profile(
    monkeypatch: pytest.MonkeyPatch, profile: str, expected: int
) -> None:
    """The CI profile plays 25 examples where a test has no number of its own, a long run 3000."""
    loaded = settings.get_profile(profile)
    monkeypatch.setattr(amounts, "settings", lambda: loaded)
    assert amounts.amount(15) == expected


def test_no_test_gets_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(amounts, "settings", lambda: settings(max_examples=1))
    assert amounts.amount(15) == 1


@pytest.mark.parametrize(("profile", "expected"), [("few", 20), ("ci", 300), ("long", 36_000)])
def test_a_number_for_quick_runs_counts_there_only(
    monkeypatch: pytest.MonkeyPatch, profile: str, expected: int
) -> None:
    loaded = settings.get_profile(profile)
    monkeypatch.setattr(amounts, "settings", lambda: loaded)
    assert amounts.amount(300, few=20) == expected
