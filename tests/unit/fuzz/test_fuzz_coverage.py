"""The coverage of a program names what was never on, never off and never reached."""

from __future__ import annotations

import pytest
from scanrack.jobs import ContactPress, Kind, Scenario, load_job
from scanrack.jobs.fuzz.explain.coverage import CoveredLine, coverage_of
from scanrack.jobs.fuzz.explain.coverage_page import save_coverage
from scanrack.jobs.fuzz.job import Setup, bench_of

RUNGS = """PROGRAM Line
TAG Lamp : BOOL
TAG Both : BOOL
TAG Zero : BOOL
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Lamp);
XIC(Lamp)XIC(Zero)OTE(Both);
XIC(Zero)JSR(Other,0);
END
ROUTINE Other
XIC(Lamp)OTE(Both);
END
"""
PYTHON = """def logic(scan):
    on = scan.slot[1].inputs[0] & 1
    if on:
        lit = 1
    else:
        lit = 0
    if on and scan.number < 2:
        lit = 2
    if scan.number >= 0:
        lit = 3
"""
RACK = """program = "{}"
run_for_s = 0.1
[[slot]]
number = 1
module = "1769-IQ16"
options = {{ inputs = {{ start = 0 }} }}
"""
PUSHED = Scenario(pushes=(ContactPress(1, "start", 20_000_000, 20_000_000),))


@pytest.fixture
def covered(tmp_path):
    def make(name, program, dead=()):
        (tmp_path / name).write_text(program, encoding="utf-8")
        rack = tmp_path / "rack.toml"
        rack.write_text(RACK.format(name), encoding="utf-8")
        bench_of.cache_clear()
        bench = bench_of(Setup(str(rack), (), (), 50, frozenset({Kind.INPUTS})))
        return {
            each.place: each.never
            for each in coverage_of(bench, (Scenario(), PUSHED), load_job(str(rack)), dead).lines
            if each.never
        }

    return make


def test_rungs_say_what_was_never_on_and_never_reached(covered):
    assert covered("line.rung", RUNGS) == {
        "Main rung 1": ("XIC(Zero): never on", "OTE(Both): never on"),
        "Main rung 2": ("XIC(Zero): never on", "JSR(Other,0): never on"),
        "Other rung 0": ("never reached",),
    }


def test_what_is_proved_dead_is_no_gap(covered):
    dead = [
        ("Main", 2, "XIC(Zero)", "on"),
        ("Main", 2, "JSR(Other,0)", "on"),
        ("Other", 0, "OTE(Both)", "reached"),
    ]
    assert list(covered("line.rung", RUNGS, dead)) == ["Main rung 1"]


def test_lines_of_python_that_no_run_has_reached(covered):
    assert covered("line.py", PYTHON) == {"line.py:8": ("never reached",), "line.py:9": ("never false",)}


def test_the_page_has_each_line_and_escapes_it(tmp_path):
    lines = [CoveredLine("a.py:1", "if a < 2:"), CoveredLine("a.py:2", "    b = 1", ("never reached",))]
    save_coverage(tmp_path / "coverage.html", "line", lines, 7)
    text = (tmp_path / "coverage.html").read_text(encoding="utf-8")
    assert "1 of 2 lines have gaps, in 7 runs" in text
    assert "<li><span>a.py:1</span><code>if a &lt; 2:</code></li>" in text
    assert '<li class="gap"><span>a.py:2</span><code>    b = 1</code><b>never reached</b></li>' in text
    assert "http" not in text.replace("http-equiv", "")
