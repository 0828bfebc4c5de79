"""Why, of racks whose logic is Python: the line, what it stands in, what the program had read."""

import sys

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.traces import open_trace
from typer.testing import CliRunner

PROGRAM = """from helper import write


class State:
    step = "first"
    seen = 0


state = State()


def logic(scan):
    inputs, outputs = scan.slot[1].inputs, scan.slot[1].outputs
    if scan.number == 3:
        if inputs.bit(0, 14) and state.step == "first":
            outputs[2] = write(outputs, state.seen)
            state.step = "second"
        else:
            outputs[7] = 1
    state.seen += 1
"""
HELPER = """def write(outputs, seen):
    outputs[3] = 30 + seen
    return 20
"""
RACK = """program = "line.py"
run_for_s = 0.02
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def rack(tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "helper", raising=False)  # that of another test's folder

    def make(program=PROGRAM, more=""):
        (tmp_path / "line.py").write_text(program, encoding="utf-8")
        (tmp_path / "helper.py").write_text(HELPER, encoding="utf-8")
        file = tmp_path / "rack.toml"
        file.write_text(RACK + more, encoding="utf-8")
        return file

    return make


@pytest.fixture
def line(rack):
    bench = open_bench(rack())
    bench.scan(6)
    return bench


def invoke(*words):
    return CliRunner().invoke(build(), list(map(str, words)))


def test_a_word_names_its_scan_its_line_its_conditions_and_what_was_read(line):
    assert line.why("Local:1:O.Data[2]").splitlines() == [
        "Local:1:O.Data[2] is 20 since 0.006 s (scan 3): line.py:16: outputs[2] = write(outputs, state.seen) "
        "[state....",
        "Cause: state.seen is 3 since 0.004 s: line.py:20: state.seen += 1",
    ]
    read = {each.name: each.value for each in line.chain("Local:1:O.Data[2]").operands}
    assert {name: read[name] for name in ("state.step", "scan.number", "state.seen")} == {
        "state.step": "'first'", "scan.number": "3", "state.seen": "3",
    }  # fmt: skip


def test_a_word_that_a_function_of_the_program_wrote_names_the_line_in_that_function(line):
    assert line.why("O:1.3").startswith(
        "O:1.3 is 33 since 0.006 s (scan 3): helper.py:2: outputs[3] = 30 + seen [seen = 3"
    )


def test_the_modules_of_a_program_are_loaded_anew_and_given_back(rack, tmp_path):
    file = rack("import helper\n\n\ndef logic(scan):\n    scan.slot[1].outputs[2] = helper.count()\n")
    helper = "calls = [0]\n\n\ndef count():\n    calls[0] += 1\n    return calls[0]\n"
    (tmp_path / "helper.py").write_text(helper, encoding="utf-8")
    bench = open_bench(file)
    bench.scan(3)
    used = sys.modules["helper"]
    assert bench.why("O:1.2").startswith("O:1.2 is 3 since 0.004 s (scan 2): line.py:5: scan.slot[1]")
    assert (sys.modules["helper"] is used, used.calls) == (True, [3])


def test_the_program_on_the_bench_goes_on_undisturbed(line):
    line.why("O:1.3")
    state = line.logic.__globals__["state"]
    assert (state.step, state.seen) == ("second", 6)
    line.scan()
    assert state.seen == 7


def test_a_bit_is_told_from_its_word(line):
    # 20 = 10100b: bit 2 and bit 4 went on with it, bit 3 never changed
    assert "is on since 0.006 s (scan 3)" in line.why("O:1.2/4")
    assert line.why("O:1.2/3") == "O:1.2/3 is off since 0 s: not changed since then"


def test_a_value_of_the_program_names_its_line(line):
    assert line.why("state.step").startswith(
        "state.step is 'second' since 0.006 s (scan 3): line.py:17: state.step = \"second\""
    )
    assert line.why("state.seen").startswith("state.seen is 6 since 0.01 s (scan 5): line.py:20: state.seen")


def test_an_input_is_the_modules_and_what_is_on_record_of_it_follows(line):
    answer = line.why("slot1.status.CONFIG_ERROR")
    assert answer.startswith(
        "slot1.status.CONFIG_ERROR is on since 0 s: slot 1: it waits for a configuration"
    )


def test_forces_and_what_a_test_writes_are_no_lines(line):
    line.force("O:1.2", 5)
    line.scan()
    assert line.why("O:1.2") == "O:1.2 is 5 since 0.012 s (scan 6): forced to 5 since 0.012 s"
    assert line.why("O:1.2/0") == "O:1.2/0 is on since 0.012 s (scan 6): forced to 5 since 0.012 s"
    line.unforce("O:1.2")
    line.scan()
    assert "line.py" not in line.why("O:1.2").splitlines()[0]  # no line took the force away


def test_a_program_that_depends_on_more_than_its_inputs_names_no_line(rack):
    bench = open_bench(
        rack("chance = [0]\n\n\ndef logic(scan):\n    scan.slot[1].outputs[2] = len(chance)\n")
    )
    bench.logic.__globals__["chance"] += [1]  # as time of day or another thread would
    bench.scan(2)
    said = " ".join(bench.why("O:1.2").split())
    assert "the program writes other words from scan 0 (0 s) on" in said


def test_a_faulted_scan_says_so(rack):
    program = "def logic(scan):\n    scan.slot[1].outputs[2] = 1 // (scan.number != 4)\n"
    bench = open_bench(rack(program))
    with pytest.raises(Exception, match="ZeroDivisionError"):
        bench.scan(9)
    assert bench.why("O:1.2").startswith("O:1.2 is 0 since 0.008 s (scan 4): the CPU faulted, by the program")
    assert "ZeroDivisionError" in bench.why("O:1.2")


@pytest.mark.slow
def test_a_scan_that_takes_longer_when_it_is_traced_is_answered(rack):
    program = """def logic(scan):
    for turn in range(scan.number * 20_000):
        pass
    scan.slot[1].outputs[2] = scan.number
"""
    file = rack(program)
    file.write_text("watchdog_ms = 50\n" + file.read_text(encoding="utf-8"), encoding="utf-8")
    bench = open_bench(file)
    bench.scan(10)  # the last one loops 180,000 times: some ms, traced far beyond the watchdog
    assert bench.why("O:1.2").startswith("O:1.2 is 9 since 0.018 s (scan 9): line.py:4: scan.slot[1]")


def test_a_program_that_did_not_come_back_does_not_hang_the_answer(rack):
    program = """def logic(scan):
    scan.slot[1].outputs[2] = scan.number
    while scan.number == 3:
        pass
"""
    file = rack(program)
    file.write_text("watchdog_ms = 100\n" + file.read_text(encoding="utf-8"), encoding="utf-8")
    result = invoke("why", file, "O:1.2", "--at", "5")
    assert "O:1.2 is 0 since 0.006 s (scan 3): the CPU faulted" in result.stdout


def test_a_question_before_the_first_scan_is_refused(rack):
    with pytest.raises(ValueError, match="no scans yet"):
        open_bench(rack()).why("O:1.2")


def test_the_bench_runs_until_a_bit_of_an_image(rack):
    bench = open_bench(rack())
    bench.run_until("O:1.2/4", within="1 s")
    assert bench.scans == 4


# --- the command


@pytest.mark.slow
def test_the_command_asks_by_scan_by_time_and_until(rack):
    file = rack()
    by_scan = invoke("why", file, "O:1.3", "--at", "4")
    assert by_scan.exit_code == 0, by_scan.output
    when, said = by_scan.stdout.splitlines()[:2]
    assert when == "after 5 scans, 0.008 s:"
    assert said.startswith("O:1.3 is 33 since 0.006 s (scan 3): helper.py:2: outputs[3] = 30 + seen")
    assert invoke("why", file, "O:1.3", "--at", "8 ms").stdout == by_scan.stdout
    assert invoke("why", file, "O:1.3", "--at", "4").stdout == by_scan.stdout
    assert invoke("why", file, "state.seen", "--until", "O:1.2/4").stdout.startswith("after 4 scans, 0.006 s")
    never = invoke("why", file, "O:1.3", "--until", "O:1.2/0")
    assert (never.exit_code, "has not become true" in never.stderr) == (1, True)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["state.stop"], "no tag matches 'state.stop'"),
        (["slot1.command.HOLD_MOV"], "no tag matches"),
        (["state.step", "--until", "Run"], "no tag matches 'Run'"),
        (["state.step", "--at", "1 parsec"], "'1 parsec' is not a time"),
    ],
)
def test_what_cannot_be_asked(rack, words, says):
    result = invoke("why", rack(), *words)
    assert (result.exit_code, says in result.stderr) == (2, True), result.stderr


@pytest.mark.slow
def test_a_trace_answers_as_its_rack_does_if_its_program_may_run(rack, tmp_path, monkeypatch):
    file, trace = rack(), tmp_path / "run.mcap"
    assert invoke("run", file, "--record", trace, "-q").exit_code == 0
    told = invoke("why", file, "O:1.3", "--at", "5").stdout.partition("\n")[2]
    trusted = invoke("why", trace, "O:1.3", "--at", "5", "--trust")
    assert trusted.exit_code == 0, trusted.output
    assert trusted.stdout == f"scan 5, 0.01 s:\n{told}"
    refused = invoke("why", trace, "O:1.3")
    assert (refused.exit_code, "then add --trust" in refused.stderr) == (2, True)
    monkeypatch.chdir(tmp_path)  # where the same files are
    assert invoke("why", trace, "O:1.3", "--until", "O:1.2/4").stdout.startswith(
        "scan 3, 0.006 s:\nO:1.3 is 33"
    )
    assert invoke("why", trace, "state.step").stdout.startswith("scan 9, 0.018 s:\nstate.step is 'second'")
    missing = invoke("why", trace, "O:1.3", "--at", "10")
    assert (missing.exit_code, "it has scans 0 to 9" in missing.stderr) == (2, True)


@pytest.mark.slow
def test_a_trace_of_a_ladder_program_answers_with_its_rungs(tmp_path):
    trace = tmp_path / "feeder.mcap"
    assert (
        invoke("run", "examples/feeder/feeder.toml", "--for", "9 s", "--record", trace, "-q").exit_code == 0
    )
    by_rack = invoke("why", "examples/feeder/feeder.toml", "Feeding", "--at", "8.2 s").stdout.partition("\n")[
        2
    ]
    assert invoke("why", trace, "Feeding", "--at", "8.2 s").stdout == f"scan 4,100, 8.2 s:\n{by_rack}"
    until = [
        invoke("why", each, "Trouble", "--until", "Trouble")
        for each in ("examples/feeder/feeder.toml", trace)
    ]
    assert until[0].stdout.partition("\n")[2] == until[1].stdout.partition("\n")[2]
    assert "Main rung 2: EQU(Axis.State,6)" in until[1].stdout


@pytest.mark.slow
def test_tags_that_were_forced_are_forced_again(tmp_path):
    trace = tmp_path / "forced.mcap"
    with open_bench("examples/feeder/feeder.toml", record=trace) as bench:
        bench.scan(100)
        bench.force("Trouble", True)
        bench.scan(100)
        assert "slot 1: " in bench.why()
        asked = bench.why("Trouble")
    answer = invoke("why", trace, "Trouble")
    assert (answer.exit_code, answer.stderr) == (0, "")
    assert asked in answer.stdout


def test_about_the_whole_rack_a_ladder_program_names_its_rungs():
    bench = open_bench("examples/three_stations_ladder/line.toml")
    bench.scan(3401)
    lines = [line.strip() for line in bench.why().splitlines()]
    assert lines[1].endswith("no command: CLR(axis.O.Data[0]) in routine Main, rung 8, whose rung was true:")
    assert lines[2] == "[XIC(axis.status.MOVING_CW),XIC(axis.status.MOVING_CCW)]CLR(axis.O.Data[0]);"


def test_a_list_of_steps_names_its_line():
    golden = "tests/golden/recordings/cmd-03-move-during-a-move.mcap"
    answer = invoke("why", golden, "slot1.command.RELATIVE_MOVE", "--at", "16").stdout.splitlines()
    assert "is on since 0.064 s (scan 16): cmd-03-move-during-a-move.steps:7: RELATIVE_MOVE" in answer[1]


def test_nothing_of_a_question_is_left_in_a_recording(rack, tmp_path):
    file, plain, asked = rack(), tmp_path / "plain.mcap", tmp_path / "asked.mcap"
    for trace, question in ((plain, None), (asked, "O:1.3")):
        with open_bench(file, record=trace) as bench:
            bench.scan(5)
            if question:
                bench.why(question)
            bench.scan(5)
    assert plain.read_bytes() == asked.read_bytes()
    with open_trace(plain) as trace:
        assert "journal" not in trace.head.metadata
