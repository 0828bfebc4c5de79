"""The comparison with another commit: its ratios, its repetitions, its exit status."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@pytest.fixture
def against(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import against

    monkeypatch.setattr(against, "has", lambda commit: commit != "unknown")
    monkeypatch.setattr(against, "archived", lambda commit, folder: folder)
    monkeypatch.setattr(against, "laid_out", lambda source, site: site)
    yield against
    for name in ("against", "against_rows"):
        sys.modules.pop(name, None)


class Side:
    """A process whose rows take the times given, one after the other; the last one for ever."""

    def __init__(self, **rows: list[float]) -> None:
        self.rows = list(rows)
        self._times = {row: list(times) for row, times in rows.items()}

    def seconds(self, row: str) -> float:
        times = self._times[row]
        return times.pop(0) if len(times) > 1 else times[0]


def measured_by(against: Any, monkeypatch: pytest.MonkeyPatch, *pairs: tuple[Side, Side]) -> None:
    """Let each start of a benchmark's processes give the next pair: the other commit's, this one's."""
    waiting = list(pairs)

    @contextmanager
    def workers(sides, benchmark):
        if not waiting:
            raise against.UnmeasuredError("its process ended")
        yield waiting.pop(0)

    monkeypatch.setattr(against, "workers", workers)


def test_a_ratio_is_the_median_of_the_pairs_with_its_quartiles(against):
    pairs = [(1.0, 1.0), (1.0, 3.0), (2.0, 2.4)]  # ratios 1, 3 and 1.2; the quartiles are at 1/4 and 3/4
    assert against.compared(pairs) == pytest.approx([1.2, 1.0, 3.0])


def test_of_one_pair_all_are_its_ratio_and_a_time_of_nothing_is_divided_by(against):
    assert against.compared([(2.0, 3.0)]) == [1.5, 1.5, 1.5]
    assert against.compared([(0.0, 2e-9)]) == pytest.approx([2.0, 2.0, 2.0])


def test_the_first_turn_of_each_side_warms_up_and_does_not_count(against, monkeypatch):
    measured_by(against, monkeypatch, (Side(scan=[9.0, 2.0]), Side(scan=[1.0, 3.0])))
    assert against.measured(("", ""), "scan", set(), 3) == {"scan": [1.5, 1.5, 1.5]}


@pytest.mark.parametrize(("this_s", "status"), [(1.08, 0), (1.09, 1)])
def test_the_status_is_1_above_the_limit(against, monkeypatch, capsys, this_s, status):
    measured_by(against, monkeypatch, *[(Side(scan=[1.0]), Side(scan=[this_s])) for _ in range(3)])
    assert against.main(["--only", "scan", "--at-most", "1.08"]) == status
    assert ("above 1.08, or not measured: scan, scan" in capsys.readouterr().out) is bool(status)


def test_a_row_above_the_limit_is_measured_again_and_its_least_ratio_counts(against, monkeypatch, capsys):
    slow = Side(a=[1.0], b=[1.0]), Side(a=[1.5], b=[1.0])
    quick = Side(a=[1.0], b=[1.0]), Side(a=[1.0], b=[2.0])
    measured_by(against, monkeypatch, slow, quick)
    assert against.main(["--only", "scan", "--at-most", "1.08"]) == 0
    rows = [line.split()[1:3] for line in capsys.readouterr().out.splitlines() if line.startswith("scan")]
    assert rows == [["a", "1.00"], ["b", "1.00"]]  # b was below in the first measurement: it is not repeated


@pytest.mark.parametrize(("this_s", "status"), [(0.6, 0), (0.61, 1)])
def test_a_row_with_a_bar_is_held_against_it_at_the_commit_of_the_bars(
    against, monkeypatch, capsys, this_s, status
):
    monkeypatch.setattr(against, "BARS", {"scan": {"a": 0.6}})
    sides = Side(a=[1.0], b=[1.0]), Side(a=[this_s], b=[9.0])
    measured_by(against, monkeypatch, *[sides] * 3)
    assert against.main(["--bars"]) == status
    said = capsys.readouterr().out
    assert f"in units of {against.BARS_OF[:12]}" in said
    assert "bar: 0.6" in said
    assert ("above their bars, or not measured: scan, a" in said) is bool(status)


def test_a_row_that_only_one_commit_has_is_told_and_does_not_count(against, monkeypatch, capsys):
    measured_by(against, monkeypatch, (Side(a=[1.0]), Side(a=[1.0], b=[9.0])))
    assert against.main(["--only", "scan", "--at-most", "1.08"]) == 0
    assert "scan, b: the other commit does not have it" in capsys.readouterr().out


def test_a_benchmark_that_does_not_run_is_told_with_status_1(against, monkeypatch, capsys):
    measured_by(against, monkeypatch)
    assert against.main(["--only", "scan"]) == 1
    assert "scan: not measured: its process ended" in capsys.readouterr().out


def test_a_clone_without_the_commit_is_told_and_is_no_failure(against, capsys):
    assert against.main(["unknown"]) == 0
    assert "does not have the commit unknown" in capsys.readouterr().out
