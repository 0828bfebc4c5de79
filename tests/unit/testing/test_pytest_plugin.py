"""The plugin of pytest: fixtures, what a failed test leaves behind, and what its report says."""

import re
import sys
from pathlib import Path

import pytest
from scanrack import open_bench, open_trace
from scanrack.testing import artifacts, page
from scanrack.watch.share.command import ShareOptions, shared
from scanrack.watch.share.failure import Failure
from tested_racks import RACK, TWO, left, write_rack

pytestmark = pytest.mark.slow  # together they take seconds

pytest_plugins = ["pytester"]

FAILED = page.FailedTest("test_line.py::test_lamp", "Lamp is off")
FEEDER = Path(__file__).parents[3] / "examples/feeder/feeder.toml"
FAULTY = "def logic(scan):\n    if scan.number == 4:\n        raise KeyError('lost')\n"


@pytest.fixture
def project(pytester):
    write_rack(pytester.path)
    yield pytester
    for name, module in list(sys.modules.items()):  # the runs of this process hid the lines of scanrack
        if name.startswith("scanrack."):
            vars(module).pop("__tracebackhide__", None)


@pytest.fixture
def run(project, monkeypatch):
    monkeypatch.setattr(artifacts, "page_line", lambda *_given: "(the page)")  # it costs a second

    def run(test, *options):
        project.makepyfile(test_line=test)
        off = ("-p", "no:hypothesispytest", "-p", "no:cacheprovider", "-p", "no:xdist")
        return project.runpytest_inprocess(*off, *options)

    return run


def section(result):
    """Return the lines of the report's section, and those of the whole report."""
    lines = result.outlines
    begin = next(row for row, line in enumerate(lines) if re.fullmatch("-+ scanrack -+", line))
    end = next(row for row, line in enumerate(lines) if row > begin and re.match("[=_]{5,}", line))
    first = next(row for row, line in enumerate(lines) if re.match("_+ .* _+$", line))
    return lines[begin + 1 : end], end - first


def test_a_failed_test_keeps_its_recording_and_says_why(project, run):
    result = run(TWO)
    result.assert_outcomes(passed=1, failed=2)
    assert left(project.path) == ["test_line.py--test_lamp/line.mcap", "test_line.py--test_rounds/line.mcap"]
    told, lines = section(result)
    assert told[0].startswith("Rounds.DN is off: Main rung 1")
    assert "line: scan 54, 0.108 s" in told
    place = "'scanrack-artifacts/test_line.py--test_rounds/line.mcap#scan=54'"
    assert told[-2:] == [f"  scanrack watch {place}", "  (the page)"]
    assert lines <= 30
    result.stdout.no_fnmatch_line("*front*bench*")  # no line of the library
    with open_trace(project.path / place.strip("'").partition("#")[0]) as trace:
        assert [each.scan for each in trace.scans()][-1] == 54


@pytest.mark.parametrize(
    ("keep", "kept"),
    [("never", []), ("all", ["test_line.py--test_dark/line.mcap", "test_line.py--test_lamp/line.mcap"])],
)
def test_what_is_kept_is_an_option(project, run, keep, kept):
    result = run(TWO, "--scanrack-keep", keep, "-k", "dark or lamp")
    result.assert_outcomes(passed=1, failed=1, deselected=1)
    assert left(project.path) == kept
    told, _ = section(result)
    assert told[0].startswith("Lamp is off since 0.01 s (scan 5)")
    assert any("scanrack watch" in line for line in told) == (keep == "all")
    assert (project.path / "scanrack-artifacts").exists() == (keep == "all")


def test_a_mended_test_leaves_nothing(project, run):
    run(TWO, "-k", "lamp")
    assert left(project.path) == ["test_line.py--test_lamp/line.mcap"]
    run(TWO.replace('assert bench["Lamp"]', 'assert not bench["Lamp"]'), "-k", "lamp")
    assert not (project.path / "scanrack-artifacts").exists()


STAGES = """
import pytest

@pytest.fixture
def started(rack):
    line = rack("line.toml")
    line.scan(3)
    yield line
    line.scan(4)  # also after a failure

@pytest.fixture
def lit(started):
    started.run_until("Lamp", within="4 ms")

def test_setup(lit): pass

def test_call(started):
    started.run_until(lambda line: line["Lamp"] or line["Rounds.DN"], within="4 ms")

@pytest.fixture
def ends_badly(rack):
    line = rack("line.toml")
    line.scan(3)
    yield
    assert line["Lamp"]

def test_teardown(ends_badly): pass

@pytest.mark.xfail(strict=True, reason="not yet")
def test_expected(rack):
    rack("line.toml").run_until("Lamp", within="4 ms")
"""


def test_each_stage_of_a_test_may_fail_and_the_recording_ends_there(project, run):
    result = run(STAGES)
    result.assert_outcomes(passed=1, failed=1, errors=2, xfailed=1)
    assert left(project.path) == [
        f"test_line.py--test_{stage}/line.mcap" for stage in ("call", "setup", "teardown")
    ]
    for stage, last in {"setup": 4, "call": 4, "teardown": 2}.items():
        result.stdout.fnmatch_lines([f"*test_{stage}/line.mcap#scan={last}'"])
        path = project.path / f"scanrack-artifacts/test_line.py--test_{stage}/line.mcap"
        with open_trace(path) as trace:
            assert [each.scan for each in trace.scans()][-1] == last
    told, _ = section(result)
    assert told[0].startswith("Lamp is off")
    result.stdout.fnmatch_lines(["Rounds.DN is off*"])  # what the function of the bench has read


def test_a_fault_names_the_scan_that_faulted_and_hides_the_library(project, run):
    (project.path / "bad.py").write_text(FAULTY, encoding="utf-8")
    (project.path / "bad.toml").write_text(RACK.replace("line.rung", "bad.py"), encoding="utf-8")
    test = "def test_bad(rack):\n    rack('bad.toml').run_for('20 ms')\n"
    result = run(test)
    told, _ = section(result)
    assert told[0] == "bad: scan 4, 0.008 s"
    result.stdout.fnmatch_lines(["bad.py:3: KeyError"])
    result.stdout.no_fnmatch_line("*cpu.py:*")
    run(test, "--full-trace").stdout.fnmatch_lines(["*cpu.py:*"])


def test_two_benches_of_one_rack_have_two_recordings(project, run):
    run("def test_two(rack):\n    for scans in (2, 5, 0): rack('line.toml').scan(scans)\n    assert 0\n")
    assert left(project.path) == [f"test_line.py--test_two/line{number}.mcap" for number in ("-2", "-3", "")]


def test_the_rack_of_the_fixture_bench_is_a_key_of_the_configuration(project, run):
    test = "def test_it(bench):\n    bench.scan()\n"
    result = run(test)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["bench: no rack; put @pytest.mark.rack*"])
    result.stdout.no_fnmatch_line("*All traceback entries are hidden*")
    project.makeini("[pytest]\nscanrack_rack = line.toml\n")
    run(test).assert_outcomes(passed=1)


@pytest.mark.parametrize("failed", [False, True])
def test_what_a_test_writes_to_its_folder_is_kept_like_its_recording(project, run, failed):
    folder = project.path / "out" / "test_line.py--test_it"
    run(
        f"def test_it(artifacts):\n    (artifacts / 'plot.svg').touch()\n    assert not {failed}\n",
        *("--scanrack-artifacts", "out"),
    )
    assert (folder / "plot.svg").exists() == failed
    assert not (project.path / "scanrack-artifacts").exists()


def test_a_page_that_can_t_be_written_is_no_second_failure(project):
    (project.path / "line.mcap").write_text("no recording", encoding="utf-8")
    assert page.page_line(project.path / "line.mcap", "line.mcap", 9, (), 0.1, FAILED).startswith("no page: ")


def test_a_long_recording_has_the_command_instead_of_the_page(project):
    for scan, run_s in ((page.MOST_SCANS, 0.1), (9, page.MOST_RUN_S + 0.1)):
        line = page.page_line(project.path / "no.mcap", "my run.mcap", scan, (), run_s, FAILED)
        assert line.startswith("scanrack share 'my run.mcap'   # the page takes some seconds")


def test_of_a_structure_nobody_asks_why():
    with open_bench(FEEDER) as feeder:
        feeder.scan(3)
        assert feeder["Out"]
        assert feeder["Homing"] in (0, 1)
        assert artifacts.tags_of(AssertionError("Out and Homing and Nowhere"), feeder) == ["Homing"]


def test_the_page_is_beside_the_recording_and_the_report_links_it(project):
    trace = project.path / "line.mcap"
    with open_bench(project.path / "line.toml", record=trace) as line:
        line.run_for("20 ms")
    link = page.page_line(trace, "line.mcap", 9, ["Lamp"], 0.1, FAILED)
    assert link == (project.path / "line.html").as_uri()
    assert (project.path / "line.html").read_bytes().lower().startswith(b"<!doctype html")


LIT = """
def test_lit(rack):
    line = rack("line.toml")
    line.scan(3)
    line.slot[1].set_input("start", True)
    line.scan({scans})
    assert line["Rounds.ACC"] == 1{more}
"""


def test_a_failure_keeps_the_run_that_passed_until_the_next_one_passes(project, run):
    kept = "test_line.py--test_lit/"
    run(LIT.format(scans=5, more=""), "--scanrack-keep", "all").assert_outcomes(passed=1)
    assert left(project.path) == [f"{kept}line.mcap"]
    for _ in range(2):  # the second failure has the same run beside it
        run(LIT.format(scans=5, more=" + 1")).assert_outcomes(failed=1)
        assert left(project.path) == [f"{kept}line.mcap", f"{kept}passed/line.mcap"]
        with open_trace(project.path / "scanrack-artifacts" / kept / "passed/line.mcap") as passed:
            assert len(list(passed.scans())) == 8
    run(LIT.format(scans=6, more=""), "--scanrack-keep", "all").assert_outcomes(passed=1)
    assert left(project.path) == [f"{kept}line.mcap"]


def test_the_page_of_a_failure_says_where_it_first_differs_from_the_run_that_passed(project):
    """The lamp is lit in scan 3 of the one and in scan 5 of the other; by then two words differ, too."""
    traces = [project.path / name for name in ("failed.mcap", "passed.mcap")]
    for trace, dark in zip(traces, (3, 5), strict=True):
        with open_bench(project.path / "line.toml", record=trace) as line:
            line.scan(dark)
            line.slot[1].set_input("start", True)
            line.scan(8 - dark)
    failure = Failure("test_line.py::test_lit", "assert 0 == 1", "Lamp", traces[1])
    data, _ = shared(traces[0], ShareOptions(7, trust=True, failure=failure))
    told = data["hello"]["failure"]
    assert (told["test"], told["message"], told["tag"], told["scan"]) == (
        "test_line.py::test_lit",
        "assert 0 == 1",
        "Lamp",
        7,
    )
    against = told["against"]
    assert (against["scan"], against["before"]) == (3, False)
    assert set(against["tags"]) == {"Local:1:I.Data.0", "Lamp", "Rounds.ACC", "Rounds.CU"}
    assert set(against["rungs"]) == {"Main.0", "Main.1"}
    assert against["others"] == ["slot 1 inputs"]
    alike = Failure("test_line.py::test_lit", "", None, traces[0])
    same, _ = shared(traces[0], ShareOptions(7, trust=True, failure=alike))
    assert same["hello"]["failure"]["against"] == {"equal_to": 7}
