"""Marks of lines: they are met as Python's own tracing meets the lines, in the same order.

Broken on purpose: no mark at the end of a turn, `continue` without one, an `elif` without one: red.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import groupby
from types import FrameType
from typing import Any

import pytest
from scanrack.ladder.python.line_marks import WATCH, LineWatch, Observer, marked_code, marked_lines

SHAPES = {
    "branches": """\
def run(value=3):
    if value > 5:
        value = 0
    elif value > 2:
        value = 1
    else:
        value = 2
    return value
""",
    "a for with break, continue and else": """\
def run():
    found = []
    for number in range(5):
        if number == 1:
            continue
        if number == 3:
            break
        found.append(number)
    else:
        found = []
    for number in ():
        found.append(number)
    else:
        found.append(9)
    return found
""",
    "a while within a while": """\
def run():
    outer = 0
    while outer < 2:
        inner = 0
        while True:
            inner += 1
            if inner < 3:
                continue
            break
        outer += 1
    return outer
""",
    "exceptions": """\
def run():
    try:
        int("x")
    except ValueError as error:
        text = str(error)
    else:
        text = ""
    finally:
        done = True
    return text, done
""",
    "a match": """\
def run(value=("b", 2)):
    match value:
        case ("b", number):
            found = number
        case ("a", _):
            found = 1
    return found
""",
    "functions in functions and on one line": '''\
def twice(value): return 2 * value

def run():
    """A docstring, which is no line."""
    total = 0
    def add(value):
        nonlocal total
        total += twice(value)
    class Local:
        def there(self):
            return total
    add(4); add(5)
    return Local().there()
''',
    "a generator": """\
def numbers():
    for each in range(2):
        yield each

def run():
    found = list(numbers())
    return found
""",
    "a class whose private names are its own": """\
class Count:
    __number = 0

    def add(self):
        self.__number += 1
        return self.__number

def run():
    count = Count()
    count.add()
    return count.add()
""",
    "a docstring and imports of the future": '''\
"""A program."""
from __future__ import annotations

def run() -> Nothing:
    global made
    made = __doc__
    return made
''',
}


class Noted(Observer):
    """Notes the lines."""

    def __init__(self) -> None:
        self.seen: list[int] = []

    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        assert (file, frame is not None and frame.f_lineno) == ("program.py", line)
        self.seen.append(line)


@contextmanager
def loaded(text: str) -> Iterator[tuple[dict[str, Any], LineWatch]]:
    """Execute a module with marks for a watch of its own."""
    watch, names = LineWatch(), {"__name__": "program"}
    before = WATCH.set(watch)
    try:
        exec(marked_code(text.encode(), "/a/folder/program.py"), names)
    finally:
        WATCH.reset(before)
    yield names, watch


def traced(call: Callable[[], object]) -> list[int]:
    """Return the lines of a call as Python traces them."""
    lines: list[int] = []

    def trace(frame: FrameType, event: str, _given: object) -> Any:
        if frame.f_code.co_filename != "<plain>" or frame.f_code.co_name == "Local":
            return None
        if event == "line":
            lines.append(frame.f_lineno)
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return lines


def without_repeats(lines: list[int]) -> list[int]:
    return [line for line, _ in groupby(lines)]


@pytest.mark.parametrize("name", SHAPES)
def test_marks_are_met_as_python_traces_lines(name: str) -> None:
    plain: dict[str, Any] = {"__name__": "program"}
    exec(compile(SHAPES[name], "<plain>", "exec"), plain)
    expected = without_repeats(traced(plain["run"]))
    with loaded(SHAPES[name]) as (names, watch):
        noted = Noted()
        watch.add(noted)
        assert names["run"]() == plain["run"]()
    assert without_repeats(noted.seen) == expected
    assert set(noted.seen) <= set(marked_lines(SHAPES[name].encode()))


def test_only_the_lines_that_an_observer_sees_are_shown() -> None:
    with loaded(SHAPES["branches"]) as (names, watch):
        some, all_ = Noted(), Noted()
        some.lines = {5}
        watch.add(some)
        names["run"]()
        watch.add(all_)
        watch.remove(some)
        names["run"](1)
        some.lines, all_.lines = {2}, set()
        watch.only(all_, some)
        names["run"](9)
        watch.only()
        names["run"]()
    assert (some.seen, all_.seen) == ([5, 2], [2, 4, 7, 8])


def test_copies_of_a_module_have_their_own_observers() -> None:
    with loaded(SHAPES["branches"]) as (names, watch), loaded(SHAPES["branches"]) as (_, other):
        here, there = Noted(), Noted()
        watch.add(here)
        other.add(there)
        names["run"]()
    assert (here.seen, there.seen) == ([2, 4, 5, 8], [])


def test_errors_show_the_lines_of_the_source() -> None:
    text = "def run():\n    if True:\n        raise KeyError(1)\n"
    with loaded(text) as (names, watch):
        watch.add(Noted())
        with pytest.raises(KeyError) as raised:
            names["run"]()
    steps = traceback.extract_tb(raised.value.__traceback__)
    assert [each.lineno for each in steps if each.filename == "/a/folder/program.py"] == [3]


def test_lines_that_run_while_a_module_is_loaded_have_no_mark() -> None:
    text = "A = 1\nif A:\n    B = 2\nclass C:\n    D = 4\n    def run(self):\n        return 7\n"
    assert list(marked_lines(text.encode())) == [7]
