"""`scanrack replay`: a recording into module, program and rack, and what differs then.

Broken on purpose: outputs sent one scan late, the recorded modes ignored, forces left out,
`--trust` always true: each turns a test red.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import forked
import pytest
from mcap.reader import make_reader
from scanrack.commands import build
from scanrack.jobs import build_cpu, build_rack, load_job
from scanrack.jobs.record.recording import recorder_for
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.runtime import Cpu, FreeRun
from scanrack.runtime.loop.scan import CpuMode, ScanFlag
from scanrack.traces import ScanRecorder, open_trace
from typer.testing import CliRunner, Result

pytestmark = pytest.mark.slow  # together they take seconds

RACK = """\
program = "{program}"
scan_ms = 2
{more}
[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"
[slot.machine]
switches = [{{ input = "cw_limit", first = {limit} }}]
timeline = [{{ at_s = 0.303, input = "external", for_ms = 50 }}]
stations = [{{ position = 400, input = "capture", work_s = 0.1, pulse_ms = 20 }}]
"""

PROGRAM = """\
from scanrack.io_images.amci3601 import Configuration, InputBit, Move, MoveKind, PresetPosition, StatusView
from speeds import SPEED

CONFIGURATION = Configuration(
    inputs_used=InputBit.CAPTURE | InputBit.EXTERNAL | InputBit.HOME | InputBit.CW_LIMIT,
    step_and_direction=True,
    starting_speed=500,
)


def logic(scan):
    status = StatusView(scan.slot[1].inputs)
    outputs = scan.slot[1].outputs
    if status.CONFIG_ERROR:
        outputs.load(CONFIGURATION.to_image())
    elif status.MODE_CONFIG:
        outputs.clear()
    elif status.POSITION_INVALID:
        outputs.load(PresetPosition(0).to_image())
    elif not outputs[0] & 1:
        outputs.load(Move(MoveKind.ABSOLUTE, 400, speed=SPEED, acceleration=2, deceleration=2).to_image())
    elif status.IN_EXTERNAL:
        outputs[7] = 3
"""

SCANS = 400


def scanrack(*arguments: object) -> Result:
    return CliRunner().invoke(build(), [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a rack, its program, and a file that the program imports."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    return tmp_path


def write(folder: Path, *, speed: int = 2000, limit: int = 9000, more: str = "") -> None:
    (folder / "rack.toml").write_text(
        RACK.format(program="line.py", limit=limit, more=more), encoding="utf-8"
    )
    (folder / "line.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "speeds.py").write_text(f"SPEED = {speed}\n", encoding="utf-8")
    sys.modules.pop("speeds", None)


def record(folder: Path, during: Callable[[Cpu, int], None] = lambda cpu, scan: None) -> Path:
    """Record the rack; `during` may act on the CPU before every scan."""
    job = load_job("rack.toml")
    rack = build_rack(job.spec)
    recorder = recorder_for(job, rack, folder / "line.mcap")
    with build_cpu(job.spec, job.logic, rack, listeners=[recorder]) as cpu:
        for scan in range(SCANS):
            during(cpu, scan)
            cpu.run(1)
    return folder / "line.mcap"


def key_and_forces(cpu: Cpu, scan: int) -> None:
    """Turn the key to program mode in mid-move and back; hold an input and an output bit for a while."""
    if scan in (60, 120):
        cpu.mode = CpuMode.PROGRAM if scan == 60 else CpuMode.RUN
    if scan == 90:
        cpu.forces.set("slot1.status.IN_CAPTURE", 1)
        cpu.forces.set("slot1.command.RESERVED_14", 1)
    if scan == 200:
        cpu.forces.clear()


@pytest.mark.parametrize("into", ["module", "program", "rack"])
@pytest.mark.parametrize("during", [lambda cpu, scan: None, key_and_forces], ids=["run", "key and forces"])
@pytest.mark.parametrize("more", ["", 'controller = "compactlogix"\nrpi_ms = 5\n'], ids=["micro", "compact"])
def test_an_unchanged_rack_answers_as_recorded(
    folder: Path, into: str, during: Callable[[Cpu, int], None], more: str
) -> None:
    write(folder, more=more)
    trace = record(folder, during)
    result = scanrack("replay", trace, "--into", into)
    assert (result.output, result.exit_code) == ("line.mcap and replay show the same: 400 scans\n", 0)


def test_a_changed_program_is_told_by_the_scan_in_which_it_decides_otherwise(folder: Path) -> None:
    trace = record(folder)
    (folder / "other.py").write_text(PROGRAM.replace("speed=SPEED", "speed=1500"), encoding="utf-8")
    result = scanrack("replay", trace, "--into", "program", "--program", "other.py")
    assert result.exit_code == 1
    assert "slot 1 out  programmed_speed      2,000   1,500  words 4 and 5: 2 0 / 1 500" in result.output
    assert "ABSOLUTE_MOVE, target 400, speed 1,500" in result.output
    with open_trace(trace) as opened:
        started = next(scan.scan for scan in opened.scans() if scan.outputs(1)[0] == 1)
    assert f"first in scan {started} at" in result.output
    assert f"note: stopped after {started + 1} of 400 scans; --to-the-end continues\n" in result.stderr
    assert "of 400 scans differ" in scanrack(
        "replay", trace, "--into", "program", "--program", "other.py", "--to-the-end"
    ).output  # fmt: skip


def test_a_changed_machine_is_told_with_the_rule_that_it_breaks(folder: Path) -> None:
    trace = record(folder)
    write(folder, limit=200)
    result = scanrack("replay", trace, "--rack", "rack.toml")
    assert result.exit_code == 1
    assert "IN_CW_LIMIT" in result.output
    assert "in replay only: INPUT_ERROR" in result.output


def test_a_program_that_faults_is_told(folder: Path) -> None:
    trace = record(folder)
    (folder / "other.py").write_text("def logic(scan):\n    assert scan.number < 50\n", encoding="utf-8")
    result = scanrack("replay", trace, "--into", "program", "--program", "other.py", "--to-the-end")
    assert result.exit_code == 1
    assert "the replay faulted in" in result.stderr


def test_counts_and_time_may_be_off_by_the_tolerance(folder: Path) -> None:
    """The input is pressed a scan later, as far as the recorded levels tell; nothing else comes later."""
    trace = record(folder)
    exact = scanrack("replay", trace, "--stimuli", "inputs")
    loose = scanrack("replay", trace, "--stimuli", "inputs", "--tolerance-time", "2ms")
    assert (exact.exit_code, loose.exit_code) in ((0, 0), (1, 0)), loose.output
    write(folder, limit=200)
    assert scanrack("replay", trace, "--rack", "rack.toml", "--tolerance-time", "2ms").exit_code == 1


def test_recorded_stimuli_take_the_place_of_the_machines_own(folder: Path) -> None:
    """The timeline of the other rack file is another one; the recorded one acts."""
    trace = record(folder)
    text = (folder / "rack.toml").read_text(encoding="utf-8")
    (folder / "other.toml").write_text(text.replace("at_s = 0.303,", "at_s = 0.2,"), encoding="utf-8")
    assert scanrack("replay", trace, "--rack", "other.toml").exit_code == 1
    assert scanrack("replay", trace, "--rack", "other.toml", "--stimuli", "recorded").exit_code == 0


def test_a_trace_that_begins_in_mid_life_is_said_to(folder: Path) -> None:
    job = load_job("rack.toml")
    rack = build_rack(job.spec)
    with build_cpu(job.spec, job.logic, rack) as cpu:
        cpu.run(100)
        cpu.add_listener(recorder_for(job, rack, folder / "late.mcap"))
        cpu.run(50)
    result = scanrack("replay", "late.mcap", "--into", "program")
    assert "note: the trace begins with scan 100: the program is assumed to have just" in result.stderr


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--slot", "3"], "--slot 3: the trace has slot 1"),
        (["--program", "line.py"], "--program needs --into program or rack"),
        (["--rack", "two.toml"], "the trace has slot 1, the rack slot 2: they must be the same"),
        (["--configuration", "8000h x"], "give words such as 843Ch 003Ch 0 500"),
        (["--configuration", "0 0"], "a configuration has bit 15 set"),
        (["--into", "rack", "--configuration", "843Ch"], "--configuration needs --into module"),
        (["--rack", "none.toml"], "no such rack file"),
    ],
)
def test_what_does_not_fit_is_told_in_one_line(folder: Path, options: list[str], says: str) -> None:
    trace = record(folder)
    two = (folder / "rack.toml").read_text(encoding="utf-8").replace("number = 1", "number = 2")
    (folder / "two.toml").write_text(two, encoding="utf-8")
    result = scanrack("replay", trace, *options)
    assert result.exit_code == 2
    assert says in result.stderr
    assert result.stderr.count("\n") == 1


def test_slots_that_the_trace_lacks_are_left_out(folder: Path) -> None:
    trace = record(folder)
    two = (folder / "rack.toml").read_text(encoding="utf-8") + '[[slot]]\nnumber = 2\nmodule = "amci3601"\n'
    (folder / "two.toml").write_text(two, encoding="utf-8")
    result = scanrack("replay", trace, "--rack", "two.toml")
    assert result.exit_code == 0, result.output
    assert "the rack's slot 2 is not in the trace and is left out" in result.stderr


def test_a_rerun_gives_the_same_bytes(folder: Path) -> None:
    trace = record(folder)
    sys.modules.pop("speeds")  # as in a process that has not run it before
    result = scanrack("replay", "--into", "session", trace, "--record", "again.mcap")
    assert (result.exit_code, result.output) == (0, "line.mcap: 400 scans, identical byte for byte\n")
    assert (folder / "again.mcap").read_bytes() == trace.read_bytes()


def test_all_files_of_a_run_come_out_of_its_trace(folder: Path) -> None:
    trace = record(folder)
    result = scanrack("show", trace, "--extract", "out")
    assert result.exit_code == 0
    assert result.output.splitlines() == ["out/line.py", "out/rack.toml", "out/speeds.py", "out/words.json"]
    for name in ("line.py", "rack.toml", "speeds.py"):
        assert (folder / "out" / name).read_bytes() == (folder / name).read_bytes()
    assert scanrack("show", trace, "--extract", "out").exit_code == 0, "the same files are no harm"
    (folder / "out" / "line.py").write_text("mine", encoding="utf-8")
    refused = scanrack("show", trace, "--extract", "out")
    assert (refused.exit_code, "out/line.py already exists" in refused.stderr) == (2, True)


def test_python_of_a_trace_is_not_run_without_trust(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trace = record(folder)
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    for command in (["replay", "--into", "session"], ["replay", "--into", "program"]):
        refused = scanrack(command[0], trace, *command[1:])
        assert refused.exit_code == 2
        assert [line.split()[0] for line in refused.stderr.splitlines()[1:-1]] == ["line.py", "speeds.py"]
        assert scanrack(command[0], trace, *command[1:], "--trust").exit_code == 0
    assert scanrack("replay", trace).exit_code == 0, "a rack in TOML is not Python"


def test_python_of_a_trace_is_run_if_it_is_that_of_the_current_folder(folder: Path) -> None:
    trace = record(folder)
    assert scanrack("replay", "--into", "session", trace).exit_code == 0
    (folder / "speeds.py").write_text("SPEED = 2001\n", encoding="utf-8")
    refused = scanrack("replay", "--into", "session", trace)
    assert refused.exit_code == 2
    assert [line.split()[0] for line in refused.stderr.splitlines()[1:-1]] == ["speeds.py"]


def test_a_rerun_in_a_process_of_its_own_uses_the_files_of_the_trace(folder: Path) -> None:
    """Not those of the current folder, which have changed."""
    trace = record(folder)
    (folder / "speeds.py").write_text("SPEED = 700\n", encoding="utf-8")
    command = [sys.executable, "-m", "scanrack", "replay", "--into", "session", str(trace), "--trust"]
    result = forked.run(command, capture_output=True, text=True, check=False, cwd=folder, encoding="utf-8")
    assert (result.returncode, result.stderr) == (0, ""), result.stdout


def test_a_rack_in_python_with_its_logic_inside_is_rerun(folder: Path) -> None:
    (folder / "press.py").write_text(
        "from scanrack.runtime.config.rackspec import RackSpec, SlotSpec\n"
        "def step(scan):\n"
        "    scan.slot[1].outputs[3] = scan.number % 7\n"
        "def made():\n"
        "    return RackSpec(program=step, slot=[SlotSpec(number=1, module='amci3601')])\n",
        encoding="utf-8",
    )
    assert scanrack("run", "press.py:made", "--scans", "30", "-q", "--record", "press.mcap").exit_code == 0
    result = scanrack("replay", "--into", "session", "press.mcap")
    assert (result.exit_code, result.output) == (0, "press.mcap: 30 scans, identical byte for byte\n")


def test_what_a_program_imports_stays_beside_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rack and program are both called line.py, so the program goes to a folder of its own."""
    cell, elsewhere = folder / "cell", folder / "elsewhere"
    for each in (cell, elsewhere):
        each.mkdir()
    (cell / "line.py").write_text(
        "from scanrack.runtime.config.rackspec import RackSpec, SlotSpec\n"
        "def rack():\n"
        "    return RackSpec(program='../line.py', slot=[SlotSpec(number=1, module='amci3601')])\n",
        encoding="utf-8",
    )
    assert scanrack("run", "cell/line.py", "--scans", "30", "-q", "--record", "line.mcap").exit_code == 0
    with open_trace(folder / "line.mcap") as trace:
        names = {each.name for each in trace.attachments()}
    assert {"line.py", "program/line.py", "program/speeds.py"} <= names
    assert "speeds.py" not in names
    monkeypatch.chdir(elsewhere)
    command = [
        sys.executable,
        "-m",
        "scanrack",
        "replay",
        "--into",
        "session",
        str(folder / "line.mcap"),
        "--trust",
    ]
    result = forked.run(command, capture_output=True, text=True, check=False, encoding="utf-8")
    assert (result.returncode, result.stderr) == (0, ""), result.stdout


def test_rungs_are_rerun_without_further_ado(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "line.rung").write_text(
        "PROGRAM blink\nTAG T : TIMER := {\"PRE\": 20}\nROUTINE Main\nXIO(T.DN)TON(T,?,?);\n"
        "XIC(T.DN)OTE(Local:1:O.Data[0].14);\nEND\n"
    , encoding="utf-8")  # fmt: skip
    (folder / "rack.toml").write_text(RACK.format(program="line.rung", limit=9000, more=""), encoding="utf-8")
    assert scanrack("run", "rack.toml", "--scans", "60", "-q", "--record", "rungs.mcap").exit_code == 0
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    result = scanrack("replay", "--into", "session", folder / "rungs.mcap")
    assert (result.exit_code, result.output) == (0, "rungs.mcap: 60 scans, identical byte for byte\n")


@pytest.mark.parametrize("name", ["../evil.py", "/evil.py", "a/../../evil.py"])
def test_a_file_that_leads_out_of_its_folder_is_refused(tmp_path: Path, name: str) -> None:
    import made_traces
    from scanrack.traces import Attachment

    recorder = ScanRecorder(
        tmp_path / "evil.mcap",
        bytearray(32),
        [made_traces.A3601],
        scan_period_ns=1,
        attachments=[Attachment(name, b"")],
    )
    recorder.scan(0, 0, 1)
    recorder.close()
    result = scanrack("show", tmp_path / "evil.mcap", "--extract", tmp_path / "out")
    assert (result.exit_code, "leads out of its folder" in result.stderr) == (2, True)
    assert not (tmp_path / "out").exists()


def test_a_replay_that_faults_early_is_not_the_same(folder: Path) -> None:
    """Even if every scan before was: the rest is missing. Its outputs are zero, as recorded in scan 0."""
    (folder / "rack.toml").write_text(RACK.format(program="still.py", limit=9000, more=""), encoding="utf-8")
    (folder / "still.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    assert scanrack("run", "rack.toml", "--scans", "60", "-q", "--record", "still.mcap").exit_code == 0
    (folder / "other.py").write_text("def logic(scan):\n    assert scan.number < 50\n", encoding="utf-8")
    result = scanrack("replay", "still.mcap", "--into", "program", "--program", "other.py")
    assert result.exit_code == 1
    assert "only in still.mcap: 9 scans" in result.output
    assert "the replay faulted in" in result.stderr


def test_a_run_that_faulted_faults_again_and_is_the_same(folder: Path) -> None:
    (folder / "rack.toml").write_text(RACK.format(program="fault.py", limit=9000, more=""), encoding="utf-8")
    (folder / "fault.py").write_text(
        "def logic(scan):\n    scan.slot[1].outputs[5] = 7\n    assert scan.number < 50\n", encoding="utf-8"
    )
    assert scanrack("run", "rack.toml", "--scans", "99", "-q", "--record", "fault.mcap").exit_code == 1
    for command in (
        ["replay", "--into", "session"],
        ["replay"],
        ["replay", "--into", "program"],
        ["replay", "--into", "rack"],
    ):
        result = scanrack(command[0], "fault.mcap", *command[1:])
        assert result.exit_code == 0, (command, result.output)


def test_power_links_torn_updates_and_the_key_come_again(folder: Path) -> None:
    """What the rack file lets happen to module and CPU is not part of the recording: it is there anew."""
    text = RACK.format(program="line.py", limit=9000, more="") + (
        '[[incident]]\nat_s = 0.2\nwhat = "power-cycle"\n'
        '[[incident]]\nat_s = 0.4\nwhat = "program-mode"\nfor_ms = 60\n'
    )
    (folder / "rack.toml").write_text(text, encoding="utf-8")
    trace = folder / "line.mcap"
    assert scanrack("run", "rack.toml", "--scans", SCANS, "-q", "--record", trace).exit_code == 0
    for into in ("module", "program", "rack"):
        result = scanrack("replay", trace, "--into", into)
        assert result.exit_code == 0, result.output


def test_scans_as_irregular_as_those_of_a_real_plc_are_replayed_at_their_times(folder: Path) -> None:
    """A module does not care how often it is asked; so a jittery recording has a jittery replay."""
    from scanrack.io_images import Image
    from scanrack.runtime import Amci3601
    from scanrack.traces import Attachment, SlotInfo

    memory, module, sent = bytearray(32), Amci3601("4.1"), Image()
    rack = 'program = "none.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    recorder = ScanRecorder(
        folder / "plc.mcap",
        memory,
        [SlotInfo(1, "amci3601", "4.1")],
        scan_period_ns=2_000_000,
        rack_file=Attachment("plc.toml", rack.encode()),
        metadata={"rack_file": "plc.toml"},
    )
    words = [[-31682, 63, 1], [0], [0x0200], [0], [2, 0, 1, 0, 5, 0, 100, 100]]
    now_ns = 0
    for scan in range(200):
        memory[16:] = module.update(now_ns, sent).raw
        sent = Image(words[min(scan // 10, 4)])
        memory[:16] = sent.raw
        recorder.scan(scan, now_ns, 1)
        now_ns += 1_700_000 + scan * scan * 7_919 % 600_000
    recorder.close()
    result = scanrack("replay", "plc.mcap")
    assert (result.output, result.exit_code) == ("plc.mcap and replay show the same: 200 scans\n", 0)
    other = scanrack("replay", "plc.mcap", "--into", "program", "--program", "none.py")
    assert "no such program file" in other.stderr


def test_scans_that_are_missing_are_told(folder: Path) -> None:
    import made_traces

    memory = bytearray(32)
    recorder = ScanRecorder(folder / "gap.mcap", memory, [made_traces.A3601], scan_period_ns=2_000_000)
    for scan in (0, 1, 2, 10, 12, 14, 16):
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    result = scanrack("replay", "gap.mcap", "--rack", "rack.toml", "--to-the-end")
    assert "note: scans 3 to 9 are missing: outputs and inputs are assumed to stay" in result.stderr
    assert "note: and so on, 4 times in all" in result.stderr
    assert "note: all scans are in program mode" in result.stderr


def test_a_recording_of_somebody_elses_needs_a_rack(folder: Path) -> None:
    import made_traces

    made_traces.record(folder / "bare.mcap", made_traces.idle(20))
    for command in (["replay"], ["replay", "--into", "session"]):
        result = scanrack(*command, "bare.mcap")
        assert result.exit_code == 2
        assert "the trace names no rack file: it can't be run without one" in result.stderr
    assert scanrack("replay", "bare.mcap", "--rack", "rack.toml").exit_code == 1


class NowAndThenLate(FreeRun):
    """Real time on a computer that is late in every seventh scan."""

    free = False

    def __init__(self) -> None:
        super().__init__()
        self.waits = 0

    def wait(self) -> bool:
        self.waits += 1
        return self.waits % 7 == 0


def test_of_a_session_in_real_time_the_flag_of_late_scans_alone_is_of_the_wall_clock(folder: Path) -> None:
    """docs/determinism.md: one bit of the flags, and nothing else in any message."""
    with ExitStack() as ports:
        options = RunOptions(folder / "live.mcap", pacer=NowAndThenLate(), handled=True)
        run = JobRun(load_job("rack.toml"), ports, options)
        run.run(400)
    result = scanrack("replay", "--into", "session", "live.mcap", "--record", "again.mcap")
    assert result.exit_code == 0, result.output
    live, again = (messages_of(folder / name) for name in ("live.mcap", "again.mcap"))
    assert [each[:2] for each in live] == [each[:2] for each in again]
    differing = [(one, other) for (_, _, one), (_, _, other) in zip(live, again, strict=True) if one != other]
    assert 50 < len(differing) < 60  # a seventh of 400
    for one, other in differing:
        assert [a ^ b for a, b in zip(one, other, strict=True) if a != b] == [ScanFlag.OVERRUN]


def messages_of(path: Path) -> list[tuple[str, int, bytes]]:
    """Return topic, time and bytes of each message."""
    with path.open("rb") as file:
        found = make_reader(file).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in found]
