"""The budget of a test: who is named, and when a run fails of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from budget import ALLOWED_S, KEY, Budget


class Lines:
    """What stands in for pytest's terminal."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.section = self.line = self.lines.append


def report(name: str, took: float, when: str = "call") -> Any:
    return SimpleNamespace(nodeid=name, when=when, user_properties=[(KEY, took)])


@pytest.fixture
def budget() -> Budget:
    """A budget that one of two tests is above, `late`."""
    found = Budget()
    found.pytest_runtest_logreport(report("in time", ALLOWED_S))
    found.pytest_runtest_logreport(report("late", ALLOWED_S + 0.01))
    found.pytest_runtest_logreport(report("its end", 9, when="teardown"))
    found.pytest_runtest_logreport(SimpleNamespace(nodeid="slow", when="call", user_properties=[]))  # type: ignore[arg-type]
    return found


def test_those_above_are_named_with_their_time(budget: Budget) -> None:
    shown: Any = Lines()
    budget.pytest_terminal_summary(shown)
    heading, *lines = shown.lines
    assert heading == "more than 1 s of the processor; 0.25 s is allowed"
    assert lines == ["  1.01 s  late"]


@pytest.mark.parametrize(("asked", "before", "after"), [("1", 0, 1), ("", 0, 0), ("1", 2, 2)])
def test_a_run_fails_of_it_only_where_that_is_asked_for(
    budget: Budget, monkeypatch: pytest.MonkeyPatch, asked: str, before: int, after: int
) -> None:
    monkeypatch.setenv("SCANRACK_BUDGET", asked)
    session: Any = SimpleNamespace(exitstatus=before)
    budget.pytest_sessionfinish(session)
    assert session.exitstatus == after


def test_a_test_notes_what_it_takes_unless_it_is_slow() -> None:
    def noted(*marks: str) -> list[str]:
        item: Any = SimpleNamespace(user_properties=[], get_closest_marker=lambda name: name in marks)
        call: Any = Budget().pytest_runtest_call(item)
        next(call)
        with pytest.raises(StopIteration):
            next(call)
        return [name for name, _ in item.user_properties]

    assert noted() == [KEY]
    assert noted("slow") == noted("costly") == []
