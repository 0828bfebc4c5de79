"""`scanrack check`: each rule finds its planted mistake, with file and line; sound racks have none."""

import json
import re
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"

RACK = """\
program = "line{suffix}"

[[slot]]
number = 1
module = "amci3601"

[slot.machine]
switches = [
    {{ input = "home", first = 10, last = 20 }},
    {{ input = "cw_limit", first = 8500 }},
]

[[slot]]
number = 2
module = "1769-IQ16"

[slot.options]
inputs = {{ start = 0, stop = 1 }}

[[slot]]
number = 3
module = "1769-OB16"

[slot.options]
outputs = {{ lamp = 0 }}
"""

RUNGS = """\
PROGRAM line
SLOT axis : 1
TAG Words : INT[8] := [16#8414, 16#0014, 0, 500, 0, 0, 0, 0]
TAG Go : INT[8] := [2, 0, 4, 0, 5, 0, 1, 1]
TAG Pulse : BOOL

ROUTINE Main
XIC(S:FS)COP(Words,axis.O.Data,8);
XIC(axis.status.MODE_CONFIG)FLL(0,axis.O.Data,8);
XIC(Local:2:I.Data.0)XIO(Local:2:I.Data.1)ONS(Pulse)COP(Go,axis.O.Data,8);
XIC(axis.status.MOVING_CW)CLR(axis.O.Data[0]);
XIC(axis.status.AT_HOME)OTE(Local:3:O.Data.0);
END
"""

PYTHON = """\
from scanrack import Configuration, FindHome, Direction, Idle, InputBit, Move, MoveKind

FAST = 5000
SETTINGS = Configuration(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, starting_speed=500)


def logic(scan):
    buttons = scan.slot[2].inputs["start"], scan.slot[2].inputs["stop"]
    scan.slot[3].outputs["lamp"] = buttons[0]
    target = scan.slot[2].inputs[3]
    scan.slot[1].outputs.load(SETTINGS.to_image())
    scan.slot[1].outputs.load(FindHome(Direction.CW, 500, 1, 1).to_image())
    scan.slot[1].outputs.load(Move(MoveKind.ABSOLUTE, target, FAST, 1, 1).to_image())
    scan.slot[1].outputs.load(Idle().to_image())
"""

SEQUENCES = """\
from scanrack import Axis3601, Configuration, Direction, Input, InputBit, Logic, Output, sequence


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, starting_speed=500))
    start = Input("start")
    stop = Input("Local:2:I.Data.1")
    lamp: Output = Output("slot3.output.lamp")

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.home(Direction.CW, speed=500, acceleration=1, deceleration=1)
        while True:
            await self.start.rises
            for target in (0, 4000):
                await self.axis.move_to(target, speed=5000, acceleration=1, deceleration=1)
            self.lamp = bool(self.stop)
"""

HOME = '    {{ input = "home", first = 10, last = 20 }},\n'
"""The home switch, line 9 of the rack."""

TWO_STEPS = """
ROUTINE Seq SFC
INITIAL_STEP A
END_STEP
STEP B
END_STEP
END
"""

PLANTED = {
    "not-configured": (".rung", RUNGS.replace("16#8414", "16#8424"), RACK, "line.toml:10"),
    "search-without-switch": (
        ".rung",
        RUNGS.replace("[2, 0, 4", "[32, 0, 0"),
        RACK.replace(HOME, ""),
        "line.rung:10",
    ),
    "unused-terminal": (
        ".rung",
        RUNGS.replace("OTE(Local:3:O.Data.0)", "OTE(Lamp)").replace(
            "TAG Pulse", "TAG Lamp : BOOL\nTAG Pulse"
        ),
        RACK,
        "line.toml:25",
    ),
    "unknown-tag": (".rung", RUNGS, 'tags = ["Pulse", "Pluse"]\n' + RACK, "line.toml:1"),
    "unreached-step": (
        ".rung",
        RUNGS.replace("TAG Pulse", "TAG A : SFC_STEP\nTAG B : SFC_STEP\nTAG Pulse") + TWO_STEPS,
        RACK,
        f"line.rung:{len(RUNGS.splitlines()) + 7}",
    ),
}
"""By rule: suffix, program and rack with the mistake, and where it is found."""


@pytest.fixture
def check(tmp_path, monkeypatch):
    """Checks a rack with a program; returns exit status, findings as (rule, place, text), and not_seen."""
    monkeypatch.chdir(tmp_path)

    def go(suffix, program, rack=RACK):
        Path(f"line{suffix}").write_text(program, encoding="utf-8")
        Path("line.toml").write_text(rack.format(suffix=suffix), encoding="utf-8")
        done = CliRunner().invoke(build(), ["check", "line.toml", "--json"])
        assert done.exit_code in (0, 1), done.output
        report = json.loads(done.stdout)
        findings = [
            (each["rule"], f"{Path(each['file']).name}:{each['line']}", each["text"])
            for each in report["findings"]
        ]
        return done.exit_code, findings, report["not_seen"]

    return go


@pytest.mark.slow
@pytest.mark.parametrize("rack", sorted(EXAMPLES.glob("*/*.toml")), ids=lambda path: f"{path.parent.name}")
def test_examples_are_clean(rack):
    done = CliRunner().invoke(build(), ["check", str(rack)])
    assert (done.exit_code, done.stdout.splitlines()[0]) == (0, "no findings")
    assert ("not seen: " in done.stdout) == (rack.parent.name != "slc")  # cards alone have no rules of a 3601


@pytest.mark.parametrize(("suffix", "program"), [(".rung", RUNGS), (".py", PYTHON), (".py", SEQUENCES)])
def test_a_sound_rack_has_no_findings(check, suffix, program):
    assert check(suffix, program)[:2] == (0, [])


@pytest.mark.parametrize("rule", PLANTED)
def test_a_planted_mistake_is_found(check, rule):
    suffix, program, rack, place = PLANTED[rule]
    status, findings, _ = check(suffix, program, rack)
    assert status == 1
    assert (rule, place) in [each[:2] for each in findings]


PYTHON_PLANTED = {
    "not-configured": ("CW_LIMIT", "CCW_LIMIT", "line.toml:10"),
    "unused-terminal": ('["lamp"]', '["lump"]', "line.toml:25"),
    "command-held": (PYTHON.splitlines()[-1], "    pass", "line.py:13"),
    "out-of-range": ("target, FAST, 1, 1", "target, FAST * 300, 1, 1", "line.py:13"),
    "out-of-range of a list": ("target, FAST", "(0, 9_000_000)[target], FAST", "line.py:13"),
    "out-of-range below the starting speed": ("target, FAST", "target, FAST - 4501", "line.py:13"),
}
"""By rule: what is replaced in the Python program by what, and where the mistake is found."""


@pytest.mark.parametrize("rule", PYTHON_PLANTED)
def test_a_planted_mistake_in_python_is_found(check, rule):
    old, new, place = PYTHON_PLANTED[rule]
    rule = rule.partition(" ")[0]
    program = PYTHON.replace(old, new)
    if rule == "command-held":
        program = program.replace('scan.slot[3].outputs["lamp"] = buttons[0]', 'print("lamp")')
    status, findings, _ = check(".py", program)
    assert status == 1
    assert (rule, place) in [each[:2] for each in findings]


SEQUENCES_PLANTED = [
    ("not-configured", "CW_LIMIT", "CCW_LIMIT", "line.toml:10"),
    ("unused-terminal", 'start = Input("start")', 'start = Input("stop")', "line.toml:18"),
    ("unused-terminal", "self.lamp = bool(self.stop)", "bool(self.stop)", "line.toml:25"),
    ("unused-terminal", "await self.start.rises", "await dwell('1 s')", "line.toml:18"),
    ("out-of-range", "speed=500, acceleration=1", "speed=500, acceleration=3000", "line.py:13"),
    ("out-of-range", "speed=5000", "speed=499", "line.py:17"),
    ("out-of-range", "(0, 4000)", "(0, 4000, 9_000_000)", "line.py:17"),
    ("out-of-range", "for target in (0, 4000)", "for target, _ in ((0, 1), (9_000_000, 2))", "line.py:17"),
    ("out-of-range", "for target in (0, 4000)", "for target in FAR", "line.py:19"),
    ("out-of-range", "for target in (0, 4000)", "for target in self.far", "line.py:18"),
    ("out-of-range", "move_to(target", "move_to(self.far[target % 2]", "line.py:18"),
    ("no-place", "    stop", "    other = Axis3601(1, axis.configuration)\n    stop", "line.py:7"),
    ("never-waits", "await self.start.rises", "while not self.start: pass", "line.py:15"),
    ("bad-call", "speed=5000, ", "", "line.py:17"),
    ("bad-call", "move_to(target, ", "move_to(target, 5000, ", "line.py:17"),
    ("bad-call", "await self.start.rises", "await self.start.rises; await dwell('2 secs')", "line.py:15"),
    ("bad-call", "await self.start.rises", "await steady(self.start.is_on, 0.5)", "line.py:15"),
]
"""Rule, what is replaced in the program with sequences by what, and where the mistake is found."""


@pytest.mark.parametrize(("rule", "old", "new", "place"), SEQUENCES_PLANTED)
def test_a_planted_mistake_in_sequences_is_found(check, rule, old, new, place):
    program = SEQUENCES.replace("Output, sequence", "Output, dwell, sequence, steady").replace(old, new)
    if "FAR" in new:
        program = program.replace("\n\nclass", "\nFAR = [0, 9_000_000]\n\n\nclass", 1)
    if "far" in new:
        program = program.replace("    start", "    far = (0, 9_000_000)\n    start", 1)
    status, findings, _ = check(".py", program)
    assert status == 1
    assert (rule, place) in [each[:2] for each in findings]


SEQUENCES_SOUND = [
    ("self.lamp = bool(self.stop)", "setattr(self, 'lamp', bool(self.stop))"),
    ("await self.start.rises", "while not self.start: await dwell('10 ms')"),
    ("await self.start.rises", "while not self.start: break"),
    ("for target in (0, 4000)", "for target in (self.stop, 4000)"),
    (
        "class Line(Logic)",
        "class Other:\n    def go(self):\n        self.axis.advance(9_000_000)\n\n\nclass Line(Logic)",
    ),
    ("self.lamp = bool(self.stop)", "self.lamp = bool(self.stop); spare.axis.advance(9_000_000)"),
    ("(0, 4000):", "(9_000_000, 4000):\n                target -= 9_000_000"),
    ("speed=500, acceleration=1, deceleration=1", "**dict(speed=5, acceleration=1, deceleration=1)"),
]


@pytest.mark.parametrize(("old", "new"), SEQUENCES_SOUND)
def test_what_may_be_meant_so_in_sequences_is_no_mistake(check, old, new):
    program = SEQUENCES.replace("Output, sequence", "Output, dwell, sequence").replace(old, new)
    assert program.count(new) == 1
    if "spare" in new:
        program = program.replace("\n\nclass Line", "\n\nspare = None\n\n\nclass Line")
    assert check(".py", program)[:2] == (0, [])


def test_the_file_of_a_base_class_is_read_too(check, tmp_path):
    (tmp_path / "base_line.py").write_text(
        SEQUENCES.replace("target, speed=5000", "target, speed=499"), encoding="utf-8"
    )
    program = "import base_line\n\n\nclass Line(base_line.Line):\n    pass\n"
    _, findings, _ = check(".py", program)
    assert [each[:2] for each in findings] == [("out-of-range", "base_line.py:17")]


def test_a_field_that_an_imported_base_class_only_annotates_is_known(check, tmp_path):
    """Its file has no future import: Python 3.14 evaluates its annotations when they are read."""
    base = SEQUENCES.replace("\n    start", "\n    count: int\n    start", 1)
    (tmp_path / "counting_line.py").write_text(base, encoding="utf-8")
    program = (
        "import counting_line\n\n\nclass Line(counting_line.Line):\n"
        "    def every_scan(self):\n        self.count = 1\n        self.count += self.count\n"
    )
    assert check(".py", program)[1] == []


def test_all_that_has_no_place_is_found_at_once(check):
    program = SEQUENCES.replace('"start"', '"strat"').replace('lamp"', 'lump"')
    _, findings, _ = check(".py", program)
    assert [each[1] for each in findings] == ["line.py:6", "line.py:8"]
    assert "did you mean start?" in findings[0][2]


def test_a_call_that_nobody_awaits_is_refused_at_its_line(tmp_path):
    (tmp_path / "line.py").write_text(SEQUENCES.replace("await self.start", "self.start"), encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK.format(suffix=".py"), encoding="utf-8")
    done = CliRunner().invoke(build(), ["check", str(tmp_path / "line.toml")])
    assert done.exit_code == 2
    assert "line.py:15: `self.start.rises` is never awaited" in done.stderr


def test_a_pattern_that_matches_nothing_in_python(check):
    rack = 'tags = [\n  "FAST",\n  "FASD",\n]\n' + RACK
    _, findings, _ = check(".py", PYTHON, rack)
    assert findings == [("unknown-tag", "line.toml:3", "no tag matches 'FASD'; did you mean FAST?")]


ANALOG = """
[[slot]]
number = 4
module = "1769-IF4"
[slot.options]
inputs = {{ level = 1, other = 2 }}

[[slot]]
number = 5
module = "1762-OF4"
[slot.options]
outputs = {{ valve = 0 }}
"""


def test_a_channel_that_is_never_read_or_written_is_found(check):
    program = RUNGS.replace("TAG Pulse", "TAG Level : INT\nTAG Pulse").replace(
        "END", "MOV(I:4.1,Level);\nEND"
    )
    _, findings, _ = check(".rung", program, RACK + ANALOG)
    assert [each[1:] for each in findings if each[0] == "unused-terminal"] == [
        ("line.toml:31", "slot 4: the program never reads input other"),
        ("line.toml:37", "slot 5: the program never writes output valve"),
    ]
    used = program.replace("END", "MOV(Local:4:I.Ch2Data,O:5.0);\nEND")
    rules = [each[0] for each in check(".rung", used, RACK + ANALOG)[1]]
    assert "unused-terminal" not in rules


def test_a_search_in_python_without_a_switch(check):
    rack = RACK.replace(HOME, "")
    _, findings, _ = check(".py", PYTHON, rack)
    assert [each[:2] for each in findings] == [("search-without-switch", "line.py:12")]


@pytest.mark.slow
def test_a_block_with_a_velocity_out_of_range_and_a_search(tmp_path):
    folder = tmp_path / "feeder"
    shutil.copytree(EXAMPLES / "feeder", folder)
    rungs, rack = folder / "feeder.rung", folder / "feeder.toml"
    rungs.write_text(
        rungs.read_text(encoding="utf-8").replace("OutGo,6000,4000", "OutGo,6000,4000000"), encoding="utf-8"
    )
    rack.write_text(
        rack.read_text(encoding="utf-8").replace(
            '    { input = "home", first = -1500, last = -1300 },\n', ""
        ),
        encoding="utf-8",
    )
    done = CliRunner().invoke(build(), ["check", str(rack)])
    assert done.exit_code == 1
    assert [line.removeprefix(str(folder)).split(": ")[:2] for line in done.stdout.splitlines()[:2]] == [
        ["/feeder.rung:37", "search-without-switch"],
        ["/feeder.rung:42", "out-of-range"],
    ]


STRUCTURED = """\
PROGRAM line
SLOT axis : 1
ROUTINE Main ST
axis.command.HOLD_MOVE := 1;
axis.command.RESUME_MOVE := 1;
IF axis.status.MOVING_CW THEN axis.command.RESUME_MOVE := 0; END_IF;
Local:1:O.Data[6] := 2001;
END
"""


def test_structured_text_is_read_too(check):
    _, findings, _ = check(".rung", STRUCTURED)
    assert [each[:2] for each in findings if each[0] != "unused-terminal"] == [
        ("command-held", "line.rung:4"),
        ("out-of-range", "line.rung:7"),
        ("refused-command", "line.rung:5"),
    ]


ENDLESS = """CONTROLLER line
INSTRUCTION Less
INOUT Count : DINT
ROUTINE Logic
SUB(Count,1,Count);
END
END INSTRUCTION
TAG Left : DINT := 3
TAG Spare : DINT
TAG One : Less
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Main MAIN Start
ROUTINE Start ST
WHILE Left > 0 DO CALL END_WHILE;
END
ROUTINE Sub
SUB(Left,1,Left);
END
END PROGRAM
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "found"),
    [
        ("JSR(Sub);", []),
        ("Less(One,Left);", []),
        ("GSV(Task,Cycle,Priority,Left);", []),
        ("Spare := Left;", ["never-waits"]),
    ],
)
def test_a_loop_ends_if_it_calls_what_may_end_it(check, call, found):
    _, findings, _ = check(".rung", ENDLESS.replace("CALL", call))
    assert [rule for rule, _, _ in findings if rule == "never-waits"] == found


def test_a_configuration_that_cannot_be_seen_is_said(check):
    program = RUNGS.replace("ONS(Pulse)", "ONS(Pulse)MOV(3,Words[0])")
    status, findings, not_seen = check(".rung", program)
    assert (status, findings) == (0, [])
    assert any("slot 1: no configuration in constants" in each for each in not_seen)


def test_a_configuration_of_a_single_word_leaves_an_input_out(check):
    """16#8424, which is -31,708 as an INT, uses the home and the CCW limit switch, and not the CW one."""
    program = RUNGS.replace("COP(Words,axis.O.Data,8)", "MOV(-31708,axis.O.Data[0])")
    _, findings, not_seen = check(".rung", "".join(re.split("TAG Words.*\n", program)))
    assert [each[:2] for each in findings] == [("not-configured", "line.toml:10")]
    assert not_seen == []


def test_routines_in_python_may_use_all(check):
    program = f"""\
from scanrack.ladder.files.rungfile import parse_program

line = parse_program({RUNGS.replace("OTE(Local:3:O.Data.0)", "JSR(LAMP,0)")!r})


@line.function
def LAMP(tags):
    tags["Local:3:O.Data.0"] = 1
"""
    status, findings, not_seen = check(".py", program, RACK.replace("line{suffix}", "line{suffix}:line"))
    assert (status, findings) == (0, [])
    assert "routines in Python (LAMP) may use any tag and any terminal" in not_seen


def test_words_of_another_card_are_no_command(check):
    """The words would be a move at 5,000 steps/s with an acceleration of 2,001, which a 3601 refuses."""
    program = RUNGS.replace("TAG Pulse", "TAG Curve : INT[8] := [1, 0, 4, 0, 5, 0, 2001, 1]\nTAG Pulse")
    program = program.replace("END", "COP(Curve,Local:5:O.Data[0],4);\nEND")
    rack = RACK + '[[slot]]\nnumber = 5\nmodule = "1762-OF4"\n'
    assert check(".rung", program, rack)[:2] == (0, [])


def test_what_cannot_be_used_is_refused(tmp_path):
    done = CliRunner().invoke(build(), ["check", str(tmp_path / "none.toml")])
    assert done.exit_code == 2


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("Local:3:O.Data.0", "Local:3:O.Data.7", ""),
        ("Local:3:O.Data.0", "Local:3:O.Data.8", "the card in slot 3 has outputs 0 to 7"),
        ("Local:3:O.Data.0", "O:3.0/8", "the card in slot 3 has outputs 0 to 7"),
        ("XIO(Local:2:I.Data.1)", "XIO(Local:3:I.Data.1)", "the card in slot 3 has no inputs"),
        ("XIO(Local:2:I.Data.1)", "XIO(Local:2:I.Data.15)", ""),
    ],
)
def test_a_terminal_that_the_card_does_not_have(check, old, new, says):
    rack = RACK.replace("1769-OB16", "1762-OW8")
    _, findings, _ = check(".rung", RUNGS.replace(old, new), rack)
    texts = [each[2] for each in findings if each[0] == "no-place"]
    assert len(texts) == bool(says)
    assert not says or says in texts[0]


def test_an_expression_that_the_check_cannot_follow_is_said_not_to_be_read(tmp_path):
    """Python compiles and runs it; its module `ast` raises a RecursionError where it prints it."""
    total = f"{'1+' * 900}1"
    (tmp_path / "line.py").write_text(
        f"TOTAL = {total}\ndef logic(scan):\n    return {total}\n", encoding="utf-8"
    )
    (tmp_path / "rack.toml").write_text(
        'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    result = CliRunner().invoke(build(), ["check", str(tmp_path / "rack.toml")])
    assert "nested too deep: only the rack file is checked" in result.output
    assert result.exit_code == 0, result.exception
