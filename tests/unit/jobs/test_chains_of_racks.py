"""Chains of causes through racks: cards, the 3601 and its rules, incidents, Python lines and sequences.

Expected by hand: from the timeline, the program and the manual's rules. A chain is written as in
`tests/unit/ladder/test_chains.py`, with the kinds of its links that are not rungs, lines or waits.
"""

import json
import os

import pytest
from chain_text import text_of
from scanrack import open_bench
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.jobs.bench.opening import loading
from scanrack.jobs.why.chains.of_run import chain_of
from typer.testing import CliRunner

pytestmark = pytest.mark.slow  # together they take seconds

CARDS = """
[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { start = 0, stop = 1, guard = 5, reset = 3 }
timeline = [
    { at_ms = 10, input = "start", for_ms = 10 },
    { at_ms = 20, input = "guard" },
    { at_ms = 40, input = "stop" },
]
[[slot]]
number = 3
module = "1769-OB16"
"""
MOTOR = """[[slot]]
number = 1
module = "amci3601"
[slot.machine]
switches = [{ input = "home", first = 100 }]
"""
RUNGS = """PROGRAM line
TAG Run : BOOL
TAG T : TIMER
TAG Late : BOOL
SLOT axis : 1
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Guard : Local:2:I.Data.5
ALIAS Lamp : Local:3:O.Data.4
ROUTINE Main
[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);
XIC(Run)XIC(Guard)OTE(Lamp);
XIC(Run)TON(T,10,0);
XIC(T.DN)OTE(Late);
END
"""
LINES = """from scanrack import Configuration, Direction, Idle, InputBit, Manual

CONFIGURE = Configuration(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, starting_speed=1000).to_image()
JOG = Manual(Direction.CW, 5000, 20, 10).to_image()


class State:
    run = False
    count = 0


state = State()


def logic(scan):
    inputs, out = scan.slot[2].inputs, scan.slot[3].outputs
    axis = scan.slot[1].outputs
    if scan.number == 0:
        axis.load(CONFIGURE)
    elif scan.number == 2:
        axis.load(Idle().to_image())
    if inputs.bit(0, 0):
        state.run = True
    if inputs.bit(0, 1):
        state.run = False
        axis.load(Idle().to_image())
    if state.run and scan.number > 3:
        axis.load(JOG)
    out[0] = 16 if state.run else 0
"""
SEQUENCES = """from scanrack import Axis3601, Configuration, Input, InputBit, Logic, Output, dwell, sequence

USED = InputBit.HOME | InputBit.CW_LIMIT
RATES = {"speed": 5000, "acceleration": 100, "deceleration": 100}


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    start = Input("slot2.input.start")
    lamp = Output("Local:3:O.Data.4")

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        await self.axis.move_to(100, **RATES)
        self.lamp = True
        await dwell("20 ms")
        self.lamp = False
        await dwell("1 h")

    @sequence
    async def sign(self) -> None:
        await self.start.rises
        await dwell("10 ms")
        self.axis.name
"""


@pytest.fixture
def made(tmp_path):
    def make(name, program, scans, more=""):
        (tmp_path / name).write_text(program, encoding="utf-8")
        file = tmp_path / "rack.toml"
        file.write_text(f'program = "{name}"\n{MOTOR}{CARDS}{more}', encoding="utf-8")
        bench = open_bench(file)
        bench.scan(scans)
        return bench

    return make


# scans of 2 ms: start is on from 5 to 9, guard from 10, stop from 20
LADDER = [
    (16, "Lamp", "Lamp on @10 < Guard on @10 input"),
    (16, "Local:3:O.Data.4", "Local:3:O.Data.4 on @10 < Guard on @10 input"),
    (16, "Run", "Run on @5 < Start on @5 input"),
    (16, "Late", "Late on @10 < T.DN on @10 < Run on @5 < Start on @5 input"),
    (30, "Lamp", "Lamp off @20 < Run off @20 < Stop on @20 input"),
    (30, "Late", "Late off @20 < T.DN off @20 < Run off @20 < Stop on @20 input"),
    (30, "Stop", "Stop on @20 input"),
    (30, "slot2.input.stop", "slot2.input.stop on @20 input"),
    (3, "Late", "Late off @0 never < T.DN off @0 never < Run off @0 never < Start off @0 input"),
]


@pytest.mark.parametrize(("scans", "what", "expected"), LADDER)
def test_a_card_is_the_end_of_a_chain(made, scans, what, expected):
    assert text_of(made("line.rung", RUNGS, scans).chain(what)) == expected


# the command of scan n is answered in scan n + 1
PYTHON = [
    (8, "Local:3:O.Data.4", "Local:3:O.Data.4 on @5 < start on @5 input"),
    (8, "state.run", "state.run on @5 < start on @5 input"),
    (8, "slot1.command.MANUAL_CW", "slot1.command.MANUAL_CW on @5 < start on @5 input"),
    (
        8,
        "slot1.status.MOVING_CW",
        "slot1.status.MOVING_CW on @6 module < slot1.command.MANUAL_CW on @5 < start on @5 input",
    ),
    (30, "state.run", "state.run off @20 < stop on @20 input"),
    (30, "slot1.command.MANUAL_CW", "slot1.command.MANUAL_CW off @20 < stop on @20 input"),
    (30, "state.count", "state.count = 0 @0 power-up"),
]


@pytest.mark.parametrize(("scans", "what", "expected"), PYTHON)
def test_lines_of_python_and_their_inputs(made, scans, what, expected):
    said = text_of(made("line.py", LINES, scans).chain(what))
    assert said.replace("slot2.input.", "") == expected


def test_a_sequence_leads_back_through_its_waits_and_the_axis(made):
    bench = made("line.py", SEQUENCES, 100)
    links = list(bench.chain("lamp").walk())
    names = [(each.kind, each.name) for each in links]
    assert names[:3] == [("line", "lamp"), ("wait", "cycle"), ("wait", "cycle")]
    assert "dwell 20 ms is over" in links[1].text
    assert ("module", "slot1.status.MOVE_COMPLETE") in names
    assert ("line", "slot1.command.ABSOLUTE_MOVE") in names


def test_a_sequence_that_waited_for_an_input(made):
    bench = made("line.py", SEQUENCES, 100)
    assert text_of(bench.chain("sign")) == "sign @10 < sign @10 < sign @5 < start on @5 input"


SINCE = [
    (LINES, 30, "state.run", 20, False, (19, True)),
    (LINES, 30, "state.count", 0, 0, None),
    (LINES, 30, "Local:3:O.Data.4", 20, False, (19, True)),
    (LINES, 30, "slot2.input.start", 10, False, (9, True)),
    (SEQUENCES, 30, "sign", 10, "is over", (9, "waits for dwell 10 ms")),
    (SEQUENCES, 8, "sign", 5, "waits for dwell 10 ms", (4, "waits for start rises")),
]


@pytest.mark.parametrize(("program", "scans", "what", "scan", "value", "last"), SINCE)
def test_since_when_and_when_it_was_last_different(made, program, scans, what, scan, value, last):
    since = made("line.py", program, scans).chain(what).since
    different = None if last is None else {"scan": last[0], "value": last[1]}
    assert since == {"scan": scan, "now_ns": scan * 2_000_000, "value": value, "last_different": different}


MOVE = "MOVE = Move(MoveKind.RELATIVE, 50, 5000, 20, 10).to_image()\n\n\n"
POWER = """
[[incident]]
at_s = 0.030
slot = 1
what = "power-cycle"
"""


def test_a_power_cycle_of_the_module_is_the_end(made):
    link = made("line.py", LINES, 40, POWER).chain("slot1.status.CONFIG_ERROR")
    assert (link.kind, link.scan) == ("incident", 15)


REMOVED = POWER.replace("power-cycle", "removed") + "for_ms = 20\n"
KEY = """
[[incident]]
at_s = 0.030
what = "program-mode"
"""


@pytest.mark.parametrize(("scans", "said"), [(20, "its input words are 0"), (26, "its input words were 0")])
def test_a_removed_module_has_no_words_that_stand_still(made, scans, said):
    link = made("line.py", LINES, scans, REMOVED).chain("slot1.status.MODULE_OK")
    assert link.kind == "incident"
    assert said in link.text
    assert "still" not in link.text


def test_an_output_that_the_key_holds_is_as_old_as_its_last_change(made):
    """Run is on since scan 5; the key is turned at 30 ms."""
    link = made("line.py", LINES, 20, KEY).chain("Local:3:O.Data.4")
    assert (link.kind, link.scan, link.value) == ("mode", 5, True)
    assert "tags keep their values, outputs are off" in link.text


def test_a_rule_of_the_module_names_its_command(made):
    """CMD-03: a move was started before the previous one was complete."""
    program = LINES.replace("        axis.load(JOG)", "        axis.load(JOG if scan.number < 12 else MOVE)")
    program = program.replace("class State", f"{MOVE}class State")
    bench = made("line.py", program.replace("Manual\n", "Manual, Move, MoveKind\n", 1), 15)
    link = bench.chain("slot1.status.COMMAND_ERROR")
    assert (link.kind, link.scan) == ("module", 13)
    assert "CMD-03" in link.text
    assert [each.name for each in link.walk()][1] == "slot1.command.RELATIVE_MOVE"


def test_the_command_prints_the_chain_and_its_data(made, tmp_path):
    made("line.rung", RUNGS, 1)
    words = ["why", str(tmp_path / "rack.toml"), "Lamp", "--at", "29"]
    said = CliRunner().invoke(build(), words).output
    assert said.splitlines() == [
        "after 30 scans, 0.058 s:",
        "Lamp is off since 0.04 s (scan 20): Main rung 1: XIC(Run)",
        "  because Run is off since 0.04 s: Main rung 0: XIO(Stop)",
        "Cause: Stop is on since 0.04 s: slot 2 input 1 (stop): The stop input is energized.",
    ]
    deep = CliRunner().invoke(build(), [*words, "--deep"]).output
    assert max(map(len, deep.splitlines())) <= 110
    assert " ".join(deep.split()).endswith(
        "Lamp off (0.04 s, Main rung 1: XIC(Run)) <- Run off (0.04 s, rung 0: XIO(Stop)) <- "
        "Stop on (0.04 s, slot 2 input 1 (stop): The stop input is energized.)"
    )
    asked = json.loads(CliRunner().invoke(build(), [*words, "--json"]).output)
    assert asked["since"] == {
        "scan": 20, "now_ns": 40_000_000, "value": False, "last_different": {"scan": 19, "value": True},
    }  # fmt: skip
    assert [(each["kind"], each["causes"]) for each in asked["chain"]] == [
        ("rung", [[1]]), ("rung", [[2]]), ("input", []),
    ]  # fmt: skip
    assert [each["name"] for each in asked["path"]] == ["Lamp", "Run", "Stop"]
    operands = {each["name"]: (each["value"], each["changed"]) for each in asked["chain"][0]["operands"]}
    assert operands == {"Run": (False, True), "Guard": (True, False)}


def test_a_recording_has_the_same_chain(made, tmp_path):
    made("line.rung", RUNGS, 1)
    file = tmp_path / "line.mcap"
    words = ["run", str(tmp_path / "rack.toml"), "--for", "60 ms", "--record", str(file), "-q"]
    run = CliRunner().invoke(build(), words)
    assert run.exit_code == 0, run.output
    said = " ".join(CliRunner().invoke(build(), ["why", str(file), "Lamp", "--deep"]).output.split())
    assert "Run off (0.04 s, rung 0: XIO(Stop)) <- Stop on (0.04 s, slot 2 input 1" in said


RECORDED = [("line.rung", RUNGS, "Late"), ("line.py", LINES, "state.run")]


@pytest.mark.parametrize(("name", "program", "what"), RECORDED)
def test_a_recorded_run_has_the_chain_of_the_bench(made, tmp_path, name, program, what):
    bench = made(name, program, 30)
    job = load_job(str(tmp_path / "rack.toml"))
    found = chain_of(bench._journal.recording(), job, what, load=loading(job, str(tmp_path / "rack.toml")))
    assert text_of(found) == text_of(bench.chain(what))


def test_what_it_would_take_names_terminals_and_is_confirmed_by_a_run(made, tmp_path):
    bench = made("line.rung", RUNGS, 30)
    remedies = bench.suggest_inputs("Lamp")
    assert (
        str(remedies) == "Lamp comes on if Start (slot 2 input 0) comes on and Stop (slot 2 input 1) goes off"
    )
    bench.force("slot2.input.start", 1)
    bench.force("slot2.input.stop", 0)
    bench.scan(remedies.found[0].scans)
    assert bench["Lamp"]
    words = ["why", str(tmp_path / "rack.toml"), "Lamp", "--at", "29", "--want", "on"]
    assert CliRunner().invoke(build(), words).output.splitlines()[-1] == (
        "Lamp comes on 0.26 s after this: open stop (slot 2), then press start (slot 2) for 60 ms"
    )
    asked = json.loads(CliRunner().invoke(build(), [*words, "--json"]).output)
    assert [each["name"] for each in asked["takes"]["sets"][0]["inputs"]] == ["Start", "Stop"]


# stop is on from scan 20; the program starts its jog from scan 4 on
PYTHON_TAKES = [
    (3, "state.run", None, ["slot2.input.start = True"], 1),
    (30, "state.run", None, ["slot2.input.start = True", "slot2.input.stop = False"], 1),
    (30, "Local:3:O.Data.4", "on", ["slot2.input.start = True", "slot2.input.stop = False"], 1),
    (3, "slot1.command.MANUAL_CW", "on", ["slot2.input.start = True"], 2),
    (15, "state.run", "off", ["slot2.input.stop = True"], 1),
    (3, "state.level", "2", ["slot4 tank = 12001"], 1),
]
TANK = """
[[slot]]
number = 4
module = "1769-IF4"
[slot.options]
inputs = { tank = 0 }
"""


@pytest.fixture
def tried(request, monkeypatch):
    """How sets of inputs are tried."""
    if request.param == "without fork":
        monkeypatch.delattr(os, "fork", raising=False)


@pytest.mark.usefixtures("tried")
@pytest.mark.parametrize(
    ("tried", "scans", "what", "wanted", "inputs", "after"),
    [
        *(("as this system does", *each) for each in PYTHON_TAKES),
        ("without fork", *PYTHON_TAKES[1]),
    ],
    indirect=["tried"],
)
def test_what_it_would_take_of_python_is_confirmed_by_a_run(made, scans, what, wanted, inputs, after):
    program = LINES.replace("    count = 0", "    count = level = 0")
    program += "    state.level = 2 if scan.slot[4].inputs[0] > 12000 else 1\n"
    remedies = made("line.py", program, scans, TANK).suggest_inputs(what, wanted)
    (remedy,) = remedies.found
    said = [f"{each.name} = {each.value}" for each in remedy.changes]
    assert (said, remedy.scans) == (inputs, after)
    again = made("line.py", program, scans, TANK)
    for each in remedy.changes:
        again.force(str(each.cell.address), int(each.value))
    again.scan(remedy.scans)
    assert again[what] == remedies.requested


def test_of_an_input_it_is_said_what_its_owner_can_do(made):
    bench = made("line.py", LINES, 3)
    remedies = bench.suggest_inputs("slot2.input.start", "on")
    assert str(remedies) == (
        "slot2.input.start is itself an input, slot 2 input 0: switch it there (timeline of the rack file, a "
        "button of the page, set_input of a bench), or force it"
    )
    assert (remedies.found, remedies.tried) == ((), 0)
    with pytest.raises(ValueError, match=r"state\.count is 0: give the value that it should have"):
        bench.suggest_inputs("state.count")


# --- two racks, a lost link, an analog input: scans of 2 ms

ONE = """PROGRAM one
TAG Go : BOOL
TAG Count : DINT
ALIAS Start : Local:2:I.Data.0
ROUTINE Main
XIC(Start)OTE(Go);
XIC(Go)MOV(5,Count);
END
"""
ONE_RACK = """program = "one.rung"
[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { start = 0 }
timeline = [ { at_ms = 31, input = "start" } ]
"""
TWO = """PROGRAM two
TAG Far : DINT
TAG Lamp : BOOL
TAG Bad : BOOL
TAG High : BOOL
TAG Moved : BOOL
SLOT axis : 1
ALIAS Level : Local:3:I.Data[0]
ROUTINE Main
EQU(Far,5)OTE(Lamp);
NEQ(axis.I.Fault,0)OTE(Bad);
GRT(Level,12000)OTE(High);
XIC(axis.status.MOVE_COMPLETE)OTE(Moved);
END
"""
TWO_RACK = """program = "two.rung"
[stubs]
Far = { rack = "one.toml", tag = "Count", rpi_ms = 20 }
[[slot]]
number = 1
module = "amci3601"
[[slot]]
number = 3
module = "1769-IF4"
[slot.options]
inputs = { level = 0 }
formats = { level = "engineering" }
ranges = { level = "4..20 mA" }
timeline = [ { at_ms = 0, input = "level", value = 4.0 }, { at_ms = 40, input = "level", value = 12.5 } ]
[[incident]]
at_s = 0.03
slot = 1
what = "link-lost"
for_ms = 20
"""
# start of the other rack is on from 31 ms: its scan 16, at 32 ms; the sample of 40 ms has it
BESIDE = [
    (
        22, "Lamp",
        "Lamp on @20 < Far = 5 @20 partner < one.toml: Count = 5 @16 < one.toml: Go on @16 < "
        "one.toml: Start on @16 input",
    ),
    (
        22, "Far",
        "Far = 5 @20 partner < one.toml: Count = 5 @16 < one.toml: Go on @16 < one.toml: Start on @16 input",
    ),
    (22, "Bad", "Bad on @15 < axis.I.Fault = -1 @15 incident"),
    (32, "Bad", "Bad off @25 < axis.I.Fault = 0 @25 incident"),
    (22, "High", "High on @20 < Level = 12500 @20 input"),
    (22, "Level", "Level = 12500 @20 input"),
    (10, "axis.status.MODULE_OK", "axis.status.MODULE_OK on @0 module"),
    (22, "axis.status.MODULE_OK", "axis.status.MODULE_OK on @15 incident"),
]  # fmt: skip


@pytest.fixture
def beside(tmp_path):
    files = {"one.rung": ONE, "one.toml": ONE_RACK, "two.rung": TWO, "two.toml": TWO_RACK}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return open_bench(tmp_path / "two.toml")


@pytest.mark.parametrize(("scans", "what", "expected"), BESIDE)
def test_a_rack_beside_a_lost_link_and_an_analog_input(beside, scans, what, expected):
    beside.scan(scans)
    assert text_of(beside.chain(what)) == expected


TAKES = [
    ("High", "off", "High goes off if Level (slot 3 input word 0) becomes 12000"),
    (
        "Moved", "on",
        "Moved comes on if axis.status.MOVE_COMPLETE (slot 1, as the module reports it) comes on",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("what", "wanted", "expected"), TAKES)
def test_what_it_would_take_of_an_analog_input_and_of_a_module(beside, what, wanted, expected):
    beside.scan(22)
    assert str(beside.suggest_inputs(what, wanted)) == expected
