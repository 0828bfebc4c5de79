"""Test routines of `.rung` and `.st` files: one routine is one test, by its ASSERTs."""

import re

import pytest
from scanrack import open_trace
from scanrack.ladder import Controller, LadderError
from scanrack.ladder.files import parse_program
from scanrack.ladder.files.testfile import read_test_file, with_test
from scanrack.testing import artifacts

pytest_plugins = ["pytester"]

RUNGS = """PROGRAM Line
TAG Lamp : BOOL
TAG Rounds : DINT
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Lamp);
ADD(Rounds,1,Rounds);
END
"""
RACK = """program = "line.rung"
[[slot]]
number = 1
module = "1769-IQ16"
"""
TESTS = """// What the line does.
TEST line.toml FOR 20 ms
TAG Seen : DINT

ROUTINE test_rounds
ADD(Seen,1,Seen)ASSERT(Seen=Rounds);
END

ROUTINE test_few
XIO(Lamp)ASSERT(Rounds<5);
END

ROUTINE test_unreached
JSR(helper,0);
XIC(Lamp)ASSERT(Rounds>0);
END

ROUTINE helper
ASSERT(Rounds>0);
END

ROUTINE test_nothing
OTU(Lamp);
END
"""
TEXT = """TEST line.toml FOR 20 ms
TAG Half : DINT
Half := Rounds / 2;
IF Half > 2 THEN
  ASSERT(Lamp OR Half < 4);
END_IF;
"""


@pytest.fixture
def project(pytester, monkeypatch):
    monkeypatch.setattr(artifacts, "page_line", lambda *_given: "(the page)")  # it costs a second
    (pytester.path / "line.rung").write_text(RUNGS, encoding="utf-8")
    (pytester.path / "line.toml").write_text(RACK, encoding="utf-8")
    return pytester


def run(project, *options):
    off = ("-p", "no:hypothesispytest", "-p", "no:cacheprovider", "-p", "no:xdist")
    again = ("-W", "ignore::pytest.PytestAssertRewriteWarning")  # this process has run other tests
    return project.runpytest_inprocess(*off, *again, *options)


def told(result, name):
    """Return what the report has of a failed test."""
    text = "\n".join(result.outlines)
    found = re.search(rf"^_+ {name} _+$(.*?)^[_=]{{5,}}", text, re.MULTILINE | re.DOTALL)
    assert found is not None, text
    return found[1]


def test_each_routine_of_a_file_is_a_test(project):
    (project.path / "test_line.rung").write_text(TESTS, encoding="utf-8")
    (project.path / "test_text.st").write_text(TEXT, encoding="utf-8")
    result = run(project)
    result.assert_outcomes(passed=1, failed=4)

    few = told(result, "test_few")
    assert "test_line.rung:10: routine test_few, rung 0, ASSERT(Rounds<5): " in few
    assert "the condition is false [Rounds = 5]" in few
    assert "╟━┨/┠━━━" in few  # the rung with its power
    assert "Rounds is 5 since 0.008 s (scan 4): Main rung 1: ADD(Rounds,1,Rounds)" in few
    place = "scanrack-artifacts/test_line.rung--test_few/line.mcap"
    assert f"scanrack watch '{place}#scan=4'" in few
    with open_trace(project.path / place) as trace:
        assert [each.scan for each in trace.scans()][-1] == 4

    unreached = told(result, "test_unreached")
    assert "not reached within 20 ms:\nroutine test_unreached, rung 1, ASSERT(Rounds>0)\n" in unreached
    assert "no ASSERT" in told(result, "test_nothing")
    # half of 8 is 4, in the eighth scan
    text = told(result, "test_text")
    assert "test_text.st:5: routine test_text, line 5, ASSERT(Lamp OR Half<4): " in text
    assert "the condition is false [Lamp = 0, Half = 4]" in text
    assert "#scan=7'" in text


def test_coverage_counts_the_program_and_not_its_tests(project):
    (project.path / "test_line.rung").write_text(TESTS, encoding="utf-8")
    result = run(project, "--rung-coverage", "--scanrack-keep", "never")
    assert [each for each in result.outlines if " lines have gaps" in each] == [
        "line.rung: 1 of 2 lines have gaps"  # the lamp is never on
    ]
    page = (project.path / "rung-coverage.html").read_text(encoding="utf-8")
    assert "OTE(Lamp): never on" in page
    assert "ASSERT" not in page


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("TEST none.toml\nROUTINE test_a\nEND\n", "none.toml: no such rack file"),
        ("TEST line.toml\nROUTINE test_a\nXIC(Far)ASSERT(Lamp);\nEND\n", "no tag Far"),
        ("TEST line.toml\nTAG Lamp : BOOL\nROUTINE test_a\nEND\n", "tag Lamp is declared twice"),
        ("TEST line.toml\nROUTINE test_a\nXIC(;\nEND\n", "test_line.rung:3: "),
        ("TEST line.toml FOR ever\nROUTINE test_a\nASSERT(Lamp);\nEND\n", "'ever'"),
        (
            "TEST line.toml\nTAG A : BOOL\n",
            "no routine with a name that begins with test_",
        ),
    ],
)
def test_a_mistake_is_told_without_a_traceback(project, text, error):
    (project.path / "test_line.rung").write_text(text, encoding="utf-8")
    result = run(project)
    assert error in result.stdout.str()
    assert ".py:" not in result.stdout.str()


def test_programs_whose_files_are_called_like_tests_are_none(project):
    (project.path / "test_line.rung").write_text(RUNGS, encoding="utf-8")
    (project.path / "test_text.st").write_text("TAG A : BOOL\nA := 1;\n", encoding="utf-8")
    (project.path / "test_empty.st").write_text("", encoding="utf-8")
    run(project).assert_outcomes()


def test_a_program_in_python_has_no_routines_to_test_it(project):
    (project.path / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (project.path / "line.toml").write_text(RACK.replace("line.rung", "line.py"), encoding="utf-8")
    (project.path / "test_line.rung").write_text(TESTS, encoding="utf-8")
    assert "the program is in Python" in run(project, "-k", "rounds").stdout.str()


PLANT = """CONTROLLER plant
TAG Shared : DINT
TASK Fast : PERIODIC 10 ms RUNS Fast
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Fast
ROUTINE Start
ADD(Shared,1,Shared);
END
END PROGRAM
PROGRAM Main
TAG Own : DINT
ROUTINE Start
ADD(Own,1,Own);
END
END PROGRAM
"""


def test_in_a_controller_it_is_a_routine_of_the_continuous_task(tmp_path):
    path = tmp_path / "test_plant.rung"
    path.write_text(
        "TEST plant.toml\nTAG Seen : DINT\nROUTINE test_own\nASSERT(Own<3);\nEND\n", encoding="utf-8"
    )
    file = read_test_file(path)
    assert file is not None
    plant = parse_program(PLANT)
    assert isinstance(plant, Controller)
    plant.build()
    with_test(plant, file, "test_own")
    both, name = with_test(plant, file, "test_own")  # the program has stayed as it was
    assert name == r"\Main.test_own"
    engine = both.compile()
    for _ in range(2):
        engine.step()
    with pytest.raises(Exception, match=r"Own = 3"):
        engine.step()
    assert r"\Main.test_own" not in {each.name for each in plant.routines}


def test_a_program_without_a_routine_is_refused(tmp_path):
    path = tmp_path / "test_plant.rung"
    path.write_text("TEST plant.toml\nROUTINE test_own\nEND\n", encoding="utf-8")
    file = read_test_file(path)
    assert file is not None
    for text in ("CONTROLLER plant\n", "PROGRAM plant\n"):
        with pytest.raises(LadderError, match="nothing to test"):
            with_test(parse_program(text), file, "test_own")
