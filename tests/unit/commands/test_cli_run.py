"""`scanrack run`: what it does, what it says, and how it ends."""

# ruff: noqa: E501 - messages are one line each

import os
import sys

import forked
import pytest
from scanrack.commands import build
from scanrack.jobs.record import recording
from scanrack.runtime import ScanFlag
from scanrack.traces import ScanRecorder, open_trace
from scanrack.traces.write.output import TraceFull
from typer.testing import CliRunner

RACK = """\
program = "line.py"
run_for_s = 0.1

[[slot]]
number = 1
module = "amci3601"
"""

# Configured in scan 0; Preset Position in scan 20; a relative move of 100 steps at 1000 steps/s,
# the starting speed, in scan 30: it takes 100 ms, from 60 ms to 160 ms. A second one comes in
# scan 41, after a scan of zeros, while the first still runs: that is Command Error 3.
PROGRAM = """\
CONFIGURE = [-31682, 63, 1, 0, 0, 0, 0, 0]
MOVE = [2, 0, 0, 100, 1, 0, 10, 10]
WORDS = {0: CONFIGURE, 10: [0] * 8, 20: [512] + [0] * 7, 21: [0] * 8, 30: MOVE, 40: [0] * 8, 41: MOVE}


def logic(scan):
    for index, word in enumerate(WORDS.get(scan.number, ())):
        scan.slot[1].outputs[index] = word
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a rack file and a program, which is also the current folder."""
    (tmp_path / "line.toml").write_text(RACK, "utf-8")
    (tmp_path / "line.py").write_text(PROGRAM, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return tmp_path


def scanrack(*arguments):
    return CliRunner().invoke(build(), ["run", *arguments])


def scans_of(path):
    with open_trace(path) as trace:
        return list(trace.scans())


def change(folder, old, new, name="line.toml"):
    text = (folder / name).read_text("utf-8")
    assert old in text
    (folder / name).write_text(text.replace(old, new), "utf-8")


def test_a_run_is_recorded_and_summed_up(folder):
    done = scanrack("line.toml")
    assert (done.exit_code, done.stderr) == (0, "")
    scans = scans_of(folder / "line.mcap")
    assert [scan.scan for scan in scans] == list(range(50))  # 0.1 s of scans of 2 ms
    lines = done.stdout.splitlines()
    assert lines[0].startswith("scans         50 (")
    assert lines[1].startswith("machine time  0.1 s, run in ")
    assert lines[2:4] == ["moves         1", f"{'':16}1 relative: still under way at the end"]
    assert lines[4] == "errors        1"
    assert "[CMD-03, chapter 6" in lines[5]
    assert lines[5].strip().startswith("COMMAND_ERROR at scan 42: a move was started before")
    assert lines[6].startswith("normal start  CONFIG_ERROR at scan 0: ")
    assert lines[-1] == f"trace         line.mcap ({(folder / 'line.mcap').stat().st_size:,} bytes)"


def test_moves_are_counted_when_they_have_ended(folder):
    done = scanrack("line.toml", "--for", "200 ms")
    assert "moves         1\n                1 relative: complete\n" in done.stdout
    assert scans_of(folder / "line.mcap")[-1].scan == 99


def test_the_number_of_scans_may_be_given(folder):
    assert scanrack("line.toml", "--scans", "7").exit_code == 0
    assert len(scans_of(folder / "line.mcap")) == 7


def test_a_part_of_a_scan_counts_as_one(folder):
    scanrack("line.toml", "--for", "4.1 ms")
    assert [scan.now_ns for scan in scans_of(folder / "line.mcap")] == [0, 2_000_000, 4_000_000]


def test_without_a_length_a_run_in_virtual_time_takes_10_s(folder):
    change(folder, "run_for_s = 0.1", "scan_ms = 100")
    scanrack("line.toml")
    assert len(scans_of(folder / "line.mcap")) == 100


def test_quiet_says_nothing(folder):
    done = scanrack("line.toml", "--quiet")
    assert (done.exit_code, done.output) == (0, "")
    assert (folder / "line.mcap").exists()


def test_no_record_leaves_no_file(folder):
    done = scanrack("line.toml", "--no-record")
    assert done.exit_code == 0
    assert done.stdout.endswith("trace         not recorded\n")
    assert sorted(path.name for path in folder.iterdir() if path.is_file()) == ["line.py", "line.toml"]


def test_the_trace_goes_where_the_rack_file_says_from_its_own_folder(folder, tmp_path_factory, monkeypatch):
    change(folder, "run_for_s", 'trace = "first.mcap"\nrun_for_s')
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    monkeypatch.chdir(elsewhere)
    assert scanrack(str(folder / "line.toml")).exit_code == 0
    assert len(scans_of(folder / "first.mcap")) == 50
    assert scanrack(str(folder / "line.toml"), "--record", "second.mcap").exit_code == 0
    assert (elsewhere / "second.mcap").read_bytes() == (folder / "first.mcap").read_bytes()


def test_a_trace_holds_what_decided_it(folder):
    scanrack("line.toml")
    with open_trace(folder / "line.mcap") as trace:
        metadata = trace.head.metadata
        attached = {file.name: file.data for file in trace.attachments()}
    assert attached["line.py"] == PROGRAM.encode()
    assert attached["line.toml"] == RACK.encode()
    assert {key: metadata[key] for key in ("name", "logic", "controller", "seed", "scan_period_ns")} == {
        "name": "rack",
        "logic": "line.py:logic",
        "controller": "micrologix",
        "seed": "0",
        "scan_period_ns": "2000000",
    }
    assert {"program_sha256", "rack_sha256"} <= set(metadata)


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(folder):
    for name, seed in (("one.mcap", "1"), ("two.mcap", "2")):
        forked.run(
            [sys.executable, "-m", "scanrack", "run", "line.toml", "--record", name, "--quiet"],
            env={**os.environ, "PYTHONHASHSEED": seed},
            cwd=folder,
            timeout=120,
            check=True,
        )
    assert (folder / "one.mcap").read_bytes() == (folder / "two.mcap").read_bytes()


def test_in_real_time_overruns_are_told(folder):
    done = scanrack("line.toml", "--realtime", "--scans", "3")
    assert done.exit_code == 0
    assert "\noverruns      " in done.stdout
    assert " ms after it was due\n" in done.stdout


def test_a_program_that_raises(folder):
    change(folder, "def logic(scan):\n", "def logic(scan):\n    1 / (25 - scan.number)\n", "line.py")
    done = scanrack("line.toml")
    assert done.exit_code == 1
    assert done.stderr == (
        "scanrack: the CPU has faulted in scan 25 (t = 0.05 s): the program raised ZeroDivisionError: "
        "division by zero [line.py:7]\n"
    )
    scans = scans_of(folder / "line.mcap")
    assert len(scans) == 26
    assert scans[-1].flags & ScanFlag.FAULT
    assert "scans         26 (" in done.stdout


def test_a_program_that_does_not_come_back(folder):
    change(folder, "run_for_s", "watchdog_ms = 80\nrun_for_s")
    change(
        folder,
        "def logic(scan):\n",
        "def logic(scan):\n    while scan.number == 3:\n        pass\n",
        "line.py",
    )
    done = scanrack("line.toml")
    assert done.exit_code == 1
    assert "scan 3 (t = 0.006 s): the watchdog ended the program: " in done.stderr
    assert "it took longer than 80" in done.stderr  # on a busy machine: 800 ms on the clock
    assert len(scans_of(folder / "line.mcap")) == 4


def test_ctrl_c_ends_a_run_in_order(folder):
    change(
        folder,
        "def logic(scan):\n",
        "import os, signal\n\n\ndef logic(scan):\n"
        "    if scan.number == 12:\n        signal.raise_signal(signal.SIGINT)\n",
        "line.py",
    )
    done = scanrack("line.toml")
    assert (done.exit_code, done.stderr) == (130, "scanrack: stopped by Ctrl-C after 13 scans\n")
    assert len(scans_of(folder / "line.mcap")) == 13
    assert "scans         13 (" in done.stdout


def test_a_second_ctrl_c_ends_it_at_once(folder):
    change(
        folder,
        "def logic(scan):\n",
        "import os, signal\n\n\ndef logic(scan):\n"
        "    while scan.number == 12:\n        signal.raise_signal(signal.SIGINT)\n",
        "line.py",
    )
    done = scanrack("line.toml")
    assert (done.exit_code, done.stderr) == (130, "scanrack: stopped by Ctrl-C in scan 12\n")
    assert len(scans_of(folder / "line.mcap")) == 12


class FillingDisk(ScanRecorder):
    """A recorder whose disk is full after scan 20."""

    def scan(self, scan, now_ns, flags):
        super().scan(scan, now_ns, flags)
        if scan == 20:
            raise TraceFull("line.mcap: the disk became full at scan 20", complete=True)


def test_a_disk_that_fills(folder, monkeypatch):
    monkeypatch.setattr(recording, "ScanRecorder", FillingDisk)
    done = scanrack("line.toml")
    assert done.exit_code == 3
    assert done.stderr == (
        "scanrack: scan 20: the trace can't be written: line.mcap: the disk became full at scan 20\n"
    )
    assert len(scans_of(folder / "line.mcap")) == 21
    assert done.stdout.startswith("scans         21 (")


class FullAtTheEnd(ScanRecorder):
    """A recorder whose disk is full when it is closed."""

    def close(self):
        super().close()
        raise TraceFull("line.mcap: the disk is full", complete=False)


def test_a_disk_that_is_full_at_the_end(folder, monkeypatch):
    monkeypatch.setattr(recording, "ScanRecorder", FullAtTheEnd)
    done = scanrack("line.toml")
    assert done.exit_code == 3
    assert done.stderr == "scanrack: the trace can't be finished: line.mcap: the disk is full\n"


def test_a_trace_that_cannot_be_written(folder):
    done = scanrack("line.toml", "--record", "nowhere/line.mcap")
    assert done.exit_code == 3
    assert done.stderr.startswith("scanrack: the trace can't be written: ")
    assert "nowhere" in done.stderr
    assert done.stdout == ""


BAD_INPUT = {
    "no rack file": (["lime.toml"], "lime.toml: no such rack file"),
    "no kind of rack file": (["line.txt"], "line.txt: a rack must be a .toml or .py file, or an"),
    "no time": (["line.toml", "--for", "10"], "'10' is not a time: write a number and a unit"),
    "no length": (["line.toml", "--for", "0 s"], "'0 s' is not a time to run for: it must be more than 0"),
    "no scans": (["line.toml", "--scans", "0"], "--scans 0: must be 1 or more"),
    "two lengths": (
        ["line.toml", "--scans", "1", "--for", "1 s"],
        "--scans and --for: give only one of them",
    ),
    "a trace over the rack file": (
        ["line.toml", "--record", "./line.toml"],
        "line.toml is the rack file: choose another file to write to",
    ),
    "a trace over the program": (
        ["line.toml", "--record", "line.py"],
        "line.py is the program: choose another file to write to",
    ),
    "two wishes": (
        ["line.toml", "--record", "x.mcap", "--no-record"],
        "--record and --no-record: give only one",
    ),
}


@pytest.mark.parametrize(("arguments", "told"), BAD_INPUT.values(), ids=BAD_INPUT)
def test_bad_input_ends_with_one_message(folder, arguments, told):
    done = scanrack(*arguments)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"scanrack: {told}")
    assert done.stderr.count("\n") == 1
    assert not (folder / "line.mcap").exists()


def test_a_mistake_in_the_rack_file_leaves_an_old_trace_alone(folder):
    (folder / "line.mcap").write_bytes(b"of yesterday")
    change(folder, "number = 1", "number = one")
    done = scanrack("line.toml")
    assert (done.exit_code, done.stderr[:21]) == (2, "scanrack: line.toml:5")
    assert (folder / "line.mcap").read_bytes() == b"of yesterday"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            '"line.py"',
            '"lime.py"',
            'line.toml:1: program = "lime.py": lime.py: no such program file',
        ),
        (
            '"line.py"',
            '"line.py:cycle"',
            'line.toml:1: program = "line.py:cycle": line.py: no function cycle among logic',
        ),
    ],
)
def test_a_program_that_is_missing(folder, old, new, told):
    change(folder, old, new)
    done = scanrack("line.toml")
    assert (done.exit_code, done.stderr) == (2, f"scanrack: {told}\n")


def test_a_program_with_a_syntax_error(folder):
    change(folder, "def logic(scan):", "def logic(scan)", "line.py")
    done = scanrack("line.toml")
    told = "scanrack: line.toml:1: program = \"line.py\": line.py:6: the program has a syntax error: expected ':'\n"
    assert (done.exit_code, done.stderr) == (2, told)


PYTHON_RACK = """\
from decimal import Decimal

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.runtime.machine import MachineSpec, Switch
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec


def logic(scan):
    scan.slot[1].outputs[0] = scan.number


def rack():
    machine = MachineSpec(switches=(Switch(InputBit.HOME, 0, 10),))
    return RackSpec(program=logic, run_for_s=Decimal("0.02"), slot=[SlotSpec(number=1, module="amci3601", machine=machine)])
"""


def test_a_rack_in_python(folder):
    (folder / "rack.py").write_text(PYTHON_RACK, "utf-8")
    done = scanrack("rack.py")
    assert done.exit_code == 0, done.output
    scans = scans_of(folder / "rack.mcap")
    assert [scan.outputs(1)[0] for scan in scans] == list(range(10))
    with open_trace(folder / "rack.mcap") as trace:
        assert trace.head.metadata["logic"] == "rack.py:logic"
        assert [file.name for file in trace.attachments()] == ["rack.py", "words.json"]


def test_a_rack_in_python_may_name_its_program_and_its_function(folder):
    (folder / "racks.py").write_text(
        PYTHON_RACK.replace("program=logic", 'program="line.py"').replace("rack()", "small()"),
        encoding="utf-8",
    )
    done = scanrack("racks.py:small")
    assert done.exit_code == 0, done.output
    with open_trace(folder / "racks.mcap") as trace:
        assert trace.head.metadata["logic"] == "line.py:logic"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("number=1", "number=0", "rack.py: number = 0: must be 1 or more"),
        (
            "    machine =",
            "    1 / 0\n    machine =",
            "rack.py:13: rack() raised ZeroDivisionError: division by zero",
        ),
        ("return RackSpec", "return str", "rack.py:14: rack() raised TypeError: "),
        ("return RackSpec(", "return dict(", "rack.py: rack() returned dict, not a RackSpec"),
        (
            "def rack()",
            "def racks()",
            "rack.py: no function rack among logic, racks; did you mean racks?",
        ),
        ("def rack()", "def rack(path)", "rack.py:12: rack(path) can't be called as rack()"),
        ("import RackSpec", "import RackSpecs", "rack.py:5: the program can't be loaded: ImportError: "),
    ],
)
def test_mistakes_in_a_rack_in_python(folder, old, new, told):
    assert old in PYTHON_RACK
    (folder / "rack.py").write_text(PYTHON_RACK.replace(old, new), "utf-8")
    done = scanrack("rack.py")
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"scanrack: {told}")
