"""The bench: what a user's test does with a rack, and what it is told when things do not come about."""

import doctest
from pathlib import Path

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.jobs.bench import NotReachedError
from scanrack.runtime.loop.faults import CpuFault
from typer.testing import CliRunner

pytestmark = pytest.mark.slow  # together they take seconds

FEEDER = "examples/feeder/feeder.toml"
PLAIN = """
def logic(scan):
    if scan.number == 5:
        raise RuntimeError("five")
"""
MOVING = """
from scanrack import Configuration, Direction, Idle, InputBit, Manual
USED = InputBit.HOME | InputBit.CW_LIMIT
CONFIGURE = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=1000)
STEPS = [CONFIGURE, Idle(), Manual(Direction.CW, 5000, 20, 10)]

def logic(scan):
    scan.slot[1].outputs.load(STEPS[min(scan.number, 2)].to_image())
"""
RUNGS = """PROGRAM line
TAG Go : BOOL
TAG Seen : BOOL
TAG Table : DINT[3]
TAG Index : DINT
SLOT axis : 1
ROUTINE Main
XIC(axis.status.IN_ESTOP)OTE(Seen);
XIC(Go)MOV(Table[Index],Index);
END
"""
RACK = """program = "{}"
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
switches = [{{ input = "home", first = 100 }}]
"""


@pytest.fixture
def rack(tmp_path):
    def make(text, name):
        (tmp_path / name).write_text(text, encoding="utf-8")
        file = tmp_path / "rack.toml"
        file.write_text(RACK.format(name), encoding="utf-8")
        return file

    return make


@pytest.fixture
def line(rack):
    return open_bench(rack(RUNGS, "line.rung"))


def test_time_goes_by_scans(line):
    line.run_for("9 ms")  # five scans of 2 ms, those at 0 to 8 ms
    assert (line.scans, line.now_ns) == (5, 8_000_000)


def test_the_shaft_is_where_it_is_in_mid_move(rack):
    bench = open_bench(rack(MOVING, "moving.py"))
    bench.run_until(lambda bench: bench.slot[1].shaft >= 1000)
    assert 1000 <= bench.slot[1].shaft < 1010  # 5000 steps/s are 10 steps per scan


SLOW = """from time import thread_time


def logic(scan):
    end = thread_time() + 0.15
    while thread_time() < end:
        pass
"""


def test_the_bench_has_no_watchdog_unless_it_is_asked_for(rack):
    file = rack(SLOW, "slow.py")
    file.write_text("watchdog_ms = 50\n" + file.read_text(encoding="utf-8"), encoding="utf-8")
    open_bench(file).scan()
    with pytest.raises(CpuFault, match="it took longer than 50"):
        open_bench(file, watched=True).scan()


def test_what_does_not_come_about_is_told_with_what_there_is(line):
    with pytest.raises(NotReachedError) as caught:
        line.run_until("Seen", within="20 ms")
    message = str(caught.value)
    assert message.startswith("Seen has not become true within 20 ms.\nafter 10 scans, 0.018 s\nslot 1: ")
    assert "CONFIG_ERROR" in message
    assert "shaft 0" in message


def test_inputs_are_pressed_and_those_of_the_machine_are_refused(line):
    line.scan()
    line.slot[1].set_input("estop", True)
    line.scan(3)
    assert "energized estop" in str(line.slot[1])
    with pytest.raises(ValueError, match="no input 'stop': inputs are capture, external"):
        line.slot[1].press("stop")
    with pytest.raises(ValueError, match="HOME is wired to the machine"):
        line.slot[1].press("home")


def test_a_fault_names_program_routine_rung_and_tag_and_the_trace_can_be_read(rack, tmp_path):
    line = open_bench(rack(RUNGS, "line.rung"), tmp_path / "t.mcap")
    line.scan(3)
    line["Index"] = 7
    line["Go"] = True
    with pytest.raises(CpuFault) as caught:
        line.scan()
    for part in ("program line", "routine Main", "rung 1", "Table[Index]", "subscript 7 is out of range"):
        assert part in str(caught.value)
    shown = CliRunner().invoke(build(), ["show", str(tmp_path / "t.mcap")])
    assert shown.exit_code == 0, shown.output
    assert "subscript 7" in shown.stdout


def test_a_plain_function_has_no_rungs_but_all_the_rest(rack):
    bench = open_bench(rack(PLAIN, "plain.py"))
    bench.scan(3)
    with pytest.raises(ValueError, match="no tag matches 'Run'"):
        bench["Run"]
    with pytest.raises(CpuFault, match="five"):
        bench.run_for("1 s")


def test_forces_of_images_are_the_cpus_and_forces_of_tags_the_programs(line):
    line.scan()
    line.force("Local:1:I.Data[1].3", 1)  # IN_ESTOP
    line.scan(2)
    assert line["Seen"]
    assert dict(line.cpu.forces.active) == {"Local:1:I.Data[1].3": 1}
    line.unforce("Local:1:I.Data[1].3")
    line.force("Seen", 0)
    line.scan(2)
    assert line.program.forces == {"Seen": False}
    with pytest.raises(ValueError, match="no tag Sean"):
        line.force("Sean", 1)


def test_trouble_power_and_the_key(line):
    slot = line.slot[1]
    line.scan(2)
    slot.inject("fatal-error")
    line.scan(2)
    assert not slot.status.MODULE_OK
    slot.inject(None)
    line.scan(2)
    assert slot.status.MODULE_OK
    slot.power_cycle()
    line.program_mode()
    line.scan(3)
    assert line.cpu.mode.name == "PROGRAM"
    line.run_mode()
    with pytest.raises(ValueError, match="no fault 'flood'; choose from link-lost"):
        slot.inject("flood")


def test_a_breakpoint_ends_a_run(line):
    line.program.break_on("Index")
    line["Table[0]"] = 2
    line.scan(2)
    line["Go"] = True
    line.run_for("1 s")
    (stop,) = line.stops
    assert str(stop) == "scan 2, 0.004 s: Index was 0 and is 2"
    assert line.scans == 3


def test_the_example_is_whole_in_every_run():
    first, second = open_bench(FEEDER), open_bench(FEEDER)
    first.run_for("1 s")
    second.run_for("1 s")
    assert first.slot[1].inputs == second.slot[1].inputs
    assert first.events == second.events
    assert first.rules == ["CER-01", "POS-01"]


# --- the commands


def invoke(*words):
    return CliRunner().invoke(build(), list(words))


def test_why_answers_at_a_time():
    result = invoke("why", FEEDER, "Feeding", "--at", "8.2 s")
    assert result.exit_code == 0, result.output
    assert "Feeding is off since 8.002 s (scan 4,001): Main rung 7: XIO(Homing)" in result.stdout
    assert "Cause: slot1.status.IN_ESTOP is on since 8.002 s" in result.stdout


def test_why_answers_when_a_bit_comes_on():
    result = invoke("why", FEEDER, "OutGo", "--until", "Feeding")
    assert result.exit_code == 0, result.output
    assert "OutGo is on since 1.57 s (scan 785): Main rung 8: XIC(Feeding)" in result.stdout


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        ((FEEDER, "Feedin"), 2, "did you mean Feeding"),
        ((FEEDER, "Feeding", "--at", "1 x"), 2, "'1 x' is not a time"),
        ((FEEDER, "Feeding", "--until", "Axis.Nothing"), 2, "AXIS_3601 has no member Nothing"),
        (("examples/three_stations/line.toml", "Run"), 2, "no tag matches 'Run'"),
        (("nowhere.toml", "Run"), 2, "nowhere.toml"),
    ],
)
def test_questions_that_cannot_be_answered(words, status, says):
    result = invoke("why", *words)
    assert result.exit_code == status
    assert says in result.stderr


def test_cross_reference_of_a_program():
    result = invoke("xref", FEEDER, "Homing")
    assert [line.split()[0:2] for line in result.stdout.splitlines()] == [
        ["Homing", "writes"],
        ["Homing", "reads"],
        ["Homing", "reads"],
    ]
    assert invoke("xref", FEEDER, "Strokes.UN").exit_code == 0
    assert invoke("xref", FEEDER, "Hominy").exit_code == 2


def test_a_tag_that_nothing_mentions(tmp_path):
    file = tmp_path / "line.rung"
    file.write_text(RUNGS.replace("TAG Go", "TAG Spare : BOOL\nTAG Go"), encoding="utf-8")
    result = invoke("xref", str(file), "Spare")
    assert (result.exit_code, result.stderr) == (1, "nothing in the program mentions Spare\n")


def test_rungs_with_the_power_of_a_scan():
    result = invoke("ladder", FEEDER, "--rung", "9", "--width", "60", "--at", "5 s")
    assert result.exit_code == 0, result.output
    assert "╟━━━┨ ┠━━━━━┤/├──" in result.stdout
    assert "needs a rack file" in invoke("ladder", "examples/feeder/feeder.rung", "--at", "5 s").stderr


@pytest.mark.parametrize(("page", "least"), [("testing", 12), ("debugging", 20)])
def test_examples_of_the_page(page, least):
    results = doctest.testfile(str(Path(__file__).parents[3] / f"docs/{page}.md"), module_relative=False)
    assert results.attempted >= least
    assert results.failed == 0
