"""The cost of the tests beside another commit's: the sample, the figures, and what a side tells."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@pytest.fixture
def suite(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import suite

    yield suite
    for name in ("suite", "against", "against_rows"):
        sys.modules.pop(name, None)


def test_the_sample_is_every_sixth_file_without_those_of_the_browser(suite: Any, tmp_path: Path) -> None:
    for number in range(13):
        for folder in ("manual", "browser"):
            file = tmp_path / "tests" / folder / f"test_{number:02}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch()
    assert suite.sample(tmp_path) == [f"tests/manual/test_{number}.py" for number in ("00", "06", "12")]


def test_a_test_that_one_side_lacks_counts_among_all_only(suite: Any) -> None:
    found = suite.rows({"a": 1.0, "b": 2.0}, {"a": 0.5, "c": 4.0}, [8.0, 6.0])
    assert found == {"the same tests": (1.0, 0.5), "all tests": (3.0, 4.5), "collecting": (8.0, 6.0)}


def test_ratios_are_medians_of_the_rounds(suite: Any, capsys: pytest.CaptureFixture[str]) -> None:
    suite.report([{"all tests": pair} for pair in ((1.0, 0.5), (2.0, 1.2), (4.0, 1.6))])
    row = capsys.readouterr().out.splitlines()[1].split()
    assert row == ["all", "tests", "2.00", "1.20", "0.50", "0.40", "to", "0.60"]


def test_a_commit_that_the_clone_lacks_is_not_compared(
    suite: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(suite, "has", lambda commit: False)
    assert suite.main(["0000000"]) == 0
    assert "this clone does not have the commit 0000000" in capsys.readouterr().out


def test_a_side_that_fails_ends_with_1(
    suite: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compare(*_: object) -> None:
        raise suite.UnmeasuredError("pytest ends with 1 in this")

    monkeypatch.setattr(suite, "has", lambda commit: True)
    monkeypatch.setattr(suite, "compare", compare)
    assert suite.main(["HEAD"]) == 1
    assert capsys.readouterr().out == "not measured: pytest ends with 1 in this\n"
