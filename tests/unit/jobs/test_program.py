"""Programs from files, and every way in which they can't be loaded."""

import hashlib
import re
import sys

import pytest
from scanrack.jobs import ProgramError, load_program
from scanrack.jobs.load import program as loaded_program
from scanrack.jobs.load.program import load_function


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Return a function that writes a file into the folder of the test and returns its path."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "modules", dict(sys.modules))

    def writing(name, text):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return writing


def refusal(address, folder):
    with pytest.raises(ProgramError) as caught:
        load_program(address, folder)
    return str(caught.value)


def test_a_program_is_loaded_with_source_and_fingerprint(write, tmp_path):
    text = "def logic(scan):\n    scan.append('called')\n"
    path = write("line.py", text)
    program = load_program("line.py", tmp_path)
    called: list[object] = []
    program.function(called)
    assert called == ["called"]
    assert (program.path, program.name, program.source) == (path, "logic", text)
    assert program.sha256 == hashlib.sha256(text.encode()).hexdigest()


def test_an_address_may_name_the_function(write, tmp_path):
    write("line.py", "def cycle(scan): return 7\n")
    assert load_program("line.py:cycle", tmp_path).function(None) == 7


def test_an_error_at_run_time_shows_the_real_file(write, tmp_path):
    path = write("line.py", "def logic(scan):\n    1 / 0\n")
    with pytest.raises(ZeroDivisionError) as caught:
        load_program("line.py", tmp_path).function(None)
    last = caught.traceback[-1]
    assert (str(last.path), last.lineno + 1) == (str(path), 2)


def test_files_beside_the_program_can_be_imported(write, tmp_path):
    write("stations_beside.py", "PLACES = (0, 4000, 8000)\n")
    write("line.py", "from stations_beside import PLACES\ndef logic(scan): return PLACES\n")
    assert load_program("line.py", tmp_path).function(None) == (0, 4000, 8000)


def test_a_program_may_define_dataclasses(write, tmp_path):
    write(
        "line.py",
        "from __future__ import annotations\n"
        "from dataclasses import dataclass\n"
        "@dataclass\nclass State:\n    step: int = 3\n"
        "def logic(scan): return State().step\n",
    )
    assert load_program("line.py", tmp_path).function(None) == 3


def test_an_object_that_can_be_called_is_a_program(write, tmp_path):
    write("line.py", "class Cycle:\n    def __call__(self, scan): return 5\nlogic = Cycle()\n")
    assert load_program("line.py", tmp_path).function(None) == 5


def test_a_missing_file(tmp_path):
    assert refusal("lime.py", tmp_path) == f"{tmp_path / 'lime.py'}: no such program file"


def test_a_folder_is_no_program(tmp_path):
    (tmp_path / "line.py").mkdir()
    assert refusal("line.py", tmp_path).startswith(f"{tmp_path / 'line.py'}: the program can't be read:")


@pytest.mark.parametrize("name", [".", "line", "line.txt", "line.PY", "line.mcap", "line.pyc"])
def test_only_three_kinds_of_file_are_programs(tmp_path, name):
    """Anything else was executed as Python."""
    says = f"{tmp_path / name}: a program must be a .py, .rung, .st, .steps, .L5X or .SLC file"
    assert refusal(name, tmp_path) == says


def test_a_syntax_error_has_its_line(write, tmp_path):
    path = write("line.py", "def logic(scan):\n    pass\n\nif True\n    pass\n")
    assert refusal("line.py", tmp_path) == f"{path}:4: the program has a syntax error: expected ':'"


@pytest.mark.parametrize("error", [SyntaxError("too deep"), MemoryError(), RecursionError("too deep")])
def test_what_is_nested_too_deep_for_python_is_refused(write, tmp_path, monkeypatch, error):
    """Python raises one of these, by version and kind of the text; here without such a text."""

    def compiles(*_args, **_named):
        raise error

    path = write("line.py", "a = 1")
    monkeypatch.setattr(loaded_program, "compile", compiles, raising=False)
    assert refusal("line.py", tmp_path).startswith(f"{path}:1: the program has ")


def test_an_error_while_loading_has_the_line_of_the_program(write, tmp_path):
    path = write("line.py", "import json\n\nTABLE = json.loads('[1,')\n")
    told = f"{path}:3: the program can't be loaded: JSONDecodeError: "
    assert refusal("line.py", tmp_path).startswith(told)


def test_no_such_function(write, tmp_path):
    path = write(
        "line.py", "import os\nfrom json import loads\ndef logics(scan): pass\ndef other(scan): pass\n"
    )
    assert refusal("line.py", tmp_path) == (
        f"{path}: no function logic among logics, other; did you mean logics?"
    )


def test_no_function_at_all(write, tmp_path):
    path = write("line.py", "x = 1\n")
    assert refusal("line.py", tmp_path) == f"{path}: no function logic"


def test_a_name_that_is_no_function(write, tmp_path):
    path = write("line.py", "logic = 3\n")
    assert refusal("line.py", tmp_path) == f"{path}: logic is int, not a function"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("\ndef logic(): pass\n", ":2: logic() can't be called as logic(scan)"),
        ("def logic(scan, rack): pass\n", ":1: logic(scan, rack) can't be called as logic(scan)"),
        ("def logic(*, scan): pass\n", ":1: logic(*, scan) can't be called as logic(scan)"),
        (
            "async def logic(scan): pass\n",
            ":1: logic must be a plain function logic(scan), without async and",
        ),
        ("def logic(scan): yield 1\n", ":1: logic must be a plain function logic(scan), without async"),
    ],
)
def test_wrong_signatures(write, tmp_path, text, told):
    write("line.py", text)
    assert told in refusal("line.py", tmp_path)


@pytest.mark.parametrize("data", [b"def logic(scan): pass  # \xff\n", b"# coding: nonsense\n", b"x = 1\0\n"])
def test_what_is_no_text(write, tmp_path, data):
    path = write("line.py", data)
    told = re.escape(str(path)) + r"(:1)?: the program (is not UTF-8 text|has a syntax error): "
    assert re.match(told, refusal("line.py", tmp_path))


def test_other_functions_are_loaded_the_same_way(write, tmp_path):
    write("rack.py", "def rack(): return 'a rack'\n")
    assert load_function("rack.py", tmp_path, default="rack", arguments=()).function() == "a rack"
