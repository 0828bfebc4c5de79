"""Breakpoints of a program in Python: which lines, and which values.

Broken on purpose: lines of the module's own text, a line observed after its breakpoint was removed: red.
"""

from types import SimpleNamespace
from typing import Any

import pytest
from scanrack.io_images.image import Image
from scanrack.ladder.files.steps import parse_steps
from scanrack.ladder.python.line_marks import WATCH, marked_code
from scanrack.watch.python_stops import PythonStops

PROGRAM = """\
class State:
    step = 0


state = State()


def logic(scan):
    state.step += 1
    if scan > 2:
        state.step = 100
"""


@pytest.fixture
def stops(tmp_path):
    path = tmp_path / "line.py"
    path.write_text(PROGRAM, encoding="utf-8")
    names: dict[str, Any] = {}
    exec(marked_code(PROGRAM.encode(), str(path)), names)
    found = PythonStops(lambda: names["logic"], path)
    yield found, names["logic"]
    WATCH.get().only()


def test_a_line_is_met_in_the_scan_in_which_it_runs(stops):
    found, logic = stops
    found.break_at("LINE.PY", 11)
    met = []
    for scan in range(4):
        logic(scan)
        met.append(found.stops)
        assert found.ran == ((9, 10, 11) if scan > 2 else (9, 10))
    assert met == [(), (), (), ("line.py line 11 has run",)]
    found.remove_breakpoint("LINE.PY", 11)
    assert not WATCH.get().observers
    logic(3)
    assert found.stops == ()


def test_a_value_is_met_when_it_changes(stops):
    found, logic = stops
    found.break_on("state.step")
    assert found.stops == ()
    logic(0)
    assert found.stops == ("state.step was 0 and is 1",)
    assert found.stops == ()


@pytest.mark.parametrize(
    ("routine", "line", "when", "says"),
    [
        ("other.py", 9, "true", "no file other.py; the program is line.py"),
        ("line.py", 2, "true", "line.py line 2: nothing runs there in a scan"),
        ("line.py", 6, "true", "nothing runs there in a scan"),
        ("line.py", 9, "changes", "a breakpoint on a line can't have the condition 'changes'"),
    ],
)
def test_what_can_not_be_waited_for_is_refused(stops, routine, line, when, says):
    with pytest.raises(ValueError, match=says):
        stops[0].break_at(routine, line, when)
    assert not WATCH.get().observers


def test_a_value_that_can_not_be_read_is_refused(stops):
    with pytest.raises(ValueError, match=r"state.none can't be read"):
        stops[0].break_on("state.none")


def test_a_step_of_a_list_is_met_when_it_begins(tmp_path):
    path = tmp_path / "moves.steps"
    path.write_text("words 1 for 4 ms\n# two more\nwords 2 for 2 ms\nzero\n", encoding="utf-8")
    steps: Any = parse_steps(path.read_text("utf-8"), str(path))
    found = PythonStops(lambda: steps, path)
    with pytest.raises(ValueError, match=r"moves\.steps line 2: nothing runs there"):
        found.break_at("moves.steps", 2)
    found.break_at("moves.steps", 3)
    slots, met = {1: SimpleNamespace(inputs=Image(), outputs=Image())}, []
    for scan in range(5):
        steps(SimpleNamespace(slot=slots, now_ns=scan * 2_000_000, first=scan == 0))
        met.append(found.stops)
    assert met == [(), (), ("moves.steps line 3 has run",), (), ()]
