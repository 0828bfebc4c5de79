"""Goals of a search: what should be seen is named if it never was, and what is to be great is kept."""

from __future__ import annotations

import pytest
from inevitable_programs import RACK, pushes
from scanrack import maximize, sometimes
from scanrack.commands import build
from scanrack.jobs import Kind
from scanrack.jobs.fuzz import InvariantError, TrialBench, search
from scanrack.jobs.fuzz.aim.edges import SIZE, STATE, Edges
from scanrack.jobs.fuzz.aim.probe import Probe
from typer.testing import CliRunner

LINE = """
def logic(scan):
    scan.slot[2].outputs[0] = scan.slot[1].inputs[0] & 1
"""
RACK_FILE = """program = "line.py"
run_for_s = 0.1
[[slot]]
number = 1
module = "1769-IQ16"
options = { inputs = { start = 0 } }
[[slot]]
number = 2
module = "1769-OB16"
"""
GOALS = '''from scanrack import sometimes

@sometimes
def lit(now):
    """The lamp is lit."""
    return now.slot[2].outputs[0] & 1

@sometimes
def other(now):
    """The other lamp is lit."""
    return now.slot[2].outputs[0] & 2
'''


@sometimes
def pressed(now):
    """The button a is pressed."""
    return now.slot[2].inputs[0] & 1


@maximize
def long(now):
    """Scans since power-up while a is pressed."""
    return now.scan if now.slot[2].inputs[0] & 1 else 0


def bench():
    return TrialBench(RACK, lambda: lambda _scan: None, (pressed, long), 60)


def test_a_run_notes_where_goals_are_reached():
    """Button a is on in the scans 20 to 49; from 20 on the sizes 20, 24, 28, 32, 40 and 48 begin a level."""
    edges = Edges()
    verdict = bench().run(pushes(("a", 20, 30)), probe=Probe(edges))
    assert verdict.greatest == {"long": 49}
    assert "pressed" in verdict.applied
    assert edges.groups[STATE]["sometimes", "pressed", "seen"] == [20]
    sizes = edges.groups[SIZE].items()
    levels = {kind[2:]: scans for kind, scans in sizes if isinstance(kind, tuple) and kind[0] == "maximize"}
    assert levels == {(5, 5): [20], (5, 6): [24], (5, 7): [28], (6, 4): [32], (6, 5): [40], (6, 6): [48]}


def test_goals_are_never_broken_and_their_runs_are_kept():
    report = search(bench(), [Kind.INPUTS], examples=30, start=1)
    assert not report.found
    assert "pressed" in report.applied
    assert report.greatest["long"] > 20
    seen = ("sometimes", "pressed", "seen")
    assert any(seen in each.edges.groups.get(STATE, {}) for each in report.corpus.entries)


@pytest.mark.slow
def test_strict_ends_with_3_if_something_was_never_seen(tmp_path):
    for name, text in (("line.py", LINE), ("line.toml", RACK_FILE), ("goals.py", GOALS)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    words = ["fuzz", str(tmp_path / "line.toml"), "-i", str(tmp_path / "goals.py"), "--runs", "12"]
    words += ["--jobs", "1", "--out", str(tmp_path / "out")]
    told = CliRunner().invoke(build(), words)
    assert told.exit_code == 0
    assert "goals         The lamp is lit [lit]: seen\n" in told.stdout
    assert "              The other lamp is lit [other]: never seen\n" in told.stdout
    assert CliRunner().invoke(build(), [*words, "--strict"]).exit_code == 3


def test_a_goal_takes_one_argument():
    with pytest.raises(InvariantError, match="must accept one argument"):
        sometimes(lambda: True)  # type: ignore[misc, arg-type]
