"""`scanrack check`: correct programs have no finding; mistakes planted in them have one.

Mistakes of PLC programmers for `scanrack check`, planted in the correct programs of `check_idioms`.
"""

# ruff: noqa: E501 - one row is one mistake

from __future__ import annotations

import pytest
from check_idioms import IDIOMS
from check_planted import Planted
from check_programs import check

DROPPED = [
    ("shuttle.rung", "refused-command", "XIC(axis.status.MOVING_CCW)]OTU(axis.command.ABSOLUTE_MOVE)MOV(20,Step);\nEQU(Step,20)XIC(axis.status.MOVE_COMPLETE)TON(Rest,800,0);\nXIC(Rest.DN)MOV(30,Step);\nEQU(Step,30)COP(Home,axis.O.Data[2],6);\nEQU(Step,30)OTL(axis.command.ABSOLUTE_MOVE)MOV(35,Step);", "XIC(axis.status.MOVING_CCW)]MOV(20,Step);\nEQU(Step,20)XIC(axis.status.MOVE_COMPLETE)TON(Rest,800,0);\nXIC(Rest.DN)MOV(30,Step);\nEQU(Step,30)COP(Home,axis.O.Data[2],6);\nEQU(Step,30)OTL(axis.command.RELATIVE_MOVE)MOV(35,Step);\nEQU(Step,40)OTU(axis.command.RELATIVE_MOVE);", "OTL(axis.command.RELATIVE_MOVE)"),
    ("table_st.rung", "command-held", "    axis.O.Data[0] := 0;\n    IF axis.status.MOVE_COMPLETE", "    IF axis.status.MOVE_COMPLETE", "    axis.O.Data[0] := 1;"),
    ("hand_stations.py", "command-held", "            outputs.set_bit(0, ABSOLUTE, False)\n", "", "            outputs.set_bit(0, ABSOLUTE, True)"),
    ("outback.steps", "command-held", "until MOVE_COMPLETE\nidle                       for 1000 ms\n", "until MOVE_COMPLETE\n", "ABSOLUTE_MOVE target -1250"),
]  # fmt: skip
"""A command bit that is not dropped before the next one."""

REFUSED = [
    ("preset.steps", "refused-command", "PRESET_POSITION target -12345  ", "PRESET_POSITION target -12345 speed 100  "),
    ("recover.steps", "refused-command", "words 8434h 0034h 0 500", "words 8424h 0024h 0 500", "FIND_HOME_CW"),
    ("homing.rung", "refused-command", "Search : INT[8] := [64, 0, 0, 0, 1,", "Search : INT[8] := [64, 1, 0, 0, 1,", "CPS(Search"),
    ("curve.steps", "no-position", "PRESET_POSITION            until -POSITION_INVALID\nzero                       for 4 ms\n", "ABSOLUTE_MOVE target 10 speed 600 acceleration 10 deceleration 10 for 1 s\nidle for 20 ms\nPRESET_POSITION            until -POSITION_INVALID\nidle for 4 ms\n", "ABSOLUTE_MOVE target 10"),
    ("jog.steps", "motion-unconfigured", "words 8434h 0034h 0 500    until MODE_CONFIG -CONFIG_ERROR\n", "", "MANUAL_CW"),
]  # fmt: skip
"""Words that the module refuses: two commands, data that a command must not have, the configuration."""

RANGES = [
    ("hand_stations.py", "out-of-range", "outputs[2], outputs[3] = split(STOPS[line.at])", "target = STOPS[line.at]\n            outputs[2] = target // 1000\n            outputs[3] = target % 1000", "outputs[3] = target"),
]  # fmt: skip
"""Numbers in words: out of range, too slow, split with opposite signs; from tables, too."""

TWICE = [
    ("debounce.rung", "block-twice", "XIC(Parts.DN)RES(Parts);\n", "XIC(Parts.DN)RES(Parts);\nJSR(Counting,0);\n", "XIC(Bounce.DN)ONS(Seen)"),
]  # fmt: skip
"""What remembers the last scan, in a routine or a helper that runs twice in one."""

BOTH = [
    ("jogbits.rung", "refused-command", "XIC(JogPlus)XIO(JogMinus)OTE(axis.command.MANUAL_CW);\nXIC(Ready)XIC(ManualKey)XIC(JogMinus)XIO(axis.command.MANUAL_CW)OTE", "XIC(JogPlus)OTE(axis.command.MANUAL_CW);\nXIC(Ready)XIC(ManualKey)XIC(JogMinus)OTE", "OTE(axis.command.MANUAL_CCW)"),
    ("hand_jogbits.py", "refused-command", "plus and not minus)\n    outputs.set_bit(0, MANUAL_CCW, minus and not plus)", "plus)\n    outputs.set_bit(0, MANUAL_CCW, minus)", "MANUAL_CCW, minus)"),
    ("reversing.rung", "no-interlock", "XIC(StopPB)XIO(Reverse)OTE(Forward);\n[XIC(RevPB)XIO(Ran),XIC(Reverse)]XIC(StopPB)XIO(Forward)OTE(Reverse)", "XIC(StopPB)OTE(Forward);\n[XIC(RevPB)XIO(Ran),XIC(Reverse)]XIC(StopPB)OTE(Reverse)", "OTE(Reverse)"),
    ("door.rung", "no-interlock", "XIC(Opening)XIO(IsOpen)XIO(Closing)OTE(OpenDoor);\nXIC(Closing)XIO(IsClosed)XIO(Opening)OTE(CloseDoor);", "XIC(OpenPB)XIO(IsOpen)OTE(OpenDoor);\nXIC(ClosePB)XIO(IsClosed)OTE(CloseDoor);\n[XIC(Opening),XIC(Closing)]NOP();", "OTE(CloseDoor)"),
]  # fmt: skip
"""Buttons without an interlock: two command bits, two opposite outputs."""

NUMBERS = [
    ("batch_st.rung", "integer-zero", "Layer := Cases / 4 MOD 5;", "Layer := Cases MOD 4 / 5;"),
    ("stations.rung", "integer-zero", "EQU(Step,10)MOV(Stops[At],Target);", "EQU(Step,10)DIV(3,4,Target)MUL(Target,Stops[At],Target);"),
    ("hand_stations.py", "integer-zero", "outputs[4], outputs[5] = 3, 500", "outputs[4], outputs[5] = 3, 500 * (1 // 2)"),
]  # fmt: skip
"""Integer divisions that are always 0, and a table of a sequence."""

TIMES = [
    ("drillunit.rung", "preset-unit", "TON(Dwell,750,0)", "TON(Dwell,2,0)"),
    ("hand_seal.py", "preset-unit", "3_000_000_000", "3_000"),
    ("wait_pick.py", "preset-unit", 'dwell("50 ms")', 'dwell("1 ns")'),
]  # fmt: skip
"""Times in another unit."""

LOOPS = [
    ("wait_pick.py", "never-waits", 'while self.closed:\n                await dwell("50 ms")', "while self.axis.moving:\n                pass"),
    ("wait_faults.py", "never-waits", "await self.axis.move_by(2500, speed=3000, acceleration=20, deceleration=20)\n                    await self.axis.move_by(-2500, speed=3000, acceleration=20, deceleration=20)", "self.horn = True", "while not self.fault"),
    ("hand_toggle.py", "never-waits", "    button.before = pressed\n", "    while pressed:\n        button.lamp = True\n    button.before = pressed\n", "while pressed"),
    ("wait_recipe.py", "never-waits", "                remaining -= 1", "                self.done = False", "while remaining"),
]  # fmt: skip
"""Loops in which nothing changes what they test."""

FRESH = [
    ('jog.steps', 'refused-command', 'idle                       until STOPPED\nMANUAL_CCW speed 300', 'MANUAL_CW MANUAL_CCW speed 300', 'MANUAL_CW MANUAL_CCW'),
    ('jog_st.rung', 'refused-command', '    IF NOT axis.status.POSITION_INVALID THEN\n        axis.command.PRESET_POSITION := 0;\n        Step := 10;', '    IF NOT axis.status.POSITION_INVALID THEN\n        Step := 10;', 'MANUAL_CW :='),
    ('shuttle.rung', 'command-held', 'OTU(axis.command.ABSOLUTE_MOVE)MOV(20,Step)', 'MOV(20,Step)', 'EQU(Step,30)OTL'),
    ('hand_jog.py', 'refused-command', 'axis.outputs.load(Manual(Direction.CW, 1500, 20, 20).to_image())', 'axis.outputs.load(Manual(Direction.CW, 1500, 20, 20).to_image())\n        axis.outputs[0] |= 1 << 8', '= 1 << 8'),
    ('homing_st.rung', 'refused-command', '20:\n    COP(Search[0], axis.O.Data[0], 8);', '20:\n    COP(Search[0], axis.O.Data[0], 8);\n    axis.command.RESET_ERRORS := 1;', 'RESET_ERRORS := 1'),
    ('hand_stations.py', 'out-of-range', '    msw, lsw = divmod(abs(value), 1000)\n    return (-msw, -lsw) if value < 0 else (msw, lsw)', '    msw, lsw = divmod(abs(value), 1000)\n    return (-msw, lsw) if value < 0 else (msw, lsw)', 'split(STOPS'),
    ('table_st.rung', 'out-of-range', 'axis.O.Data[3] := Target MOD 1000;', 'axis.O.Data[3] := ABS(Target MOD 1000);', 'ABS(Target'),
    ('hand_stations.py', 'lossy-conversion', 'STOPS = (0, -2500, 4000, 8250)', 'STOPS = (0, -2500, 4000, 82500000)', 'split(STOPS'),
    ('wait_pick.py', 'out-of-range', '"place": 7250', '"place": 72500000', 'move_to(target'),
    ('wait_recipe.py', 'out-of-range', '(4000, 9000, 60)', '(4000, 9000, 6000)', 'move_by(distance'),
    ('shuttle.rung', 'out-of-range', 'Out : INT[6] := [12, 500, 4, 0, 50, 50]', 'Out : INT[6] := [12, 500, 4, 0, 50, 5000]', 'COP(Out'),
    ('outback.steps', 'out-of-range', 'FIND_HOME_CCW speed 1000', 'FIND_HOME_CCW speed 100', 'FIND_HOME_CCW'),
    ('homing.rung', 'out-of-range', 'Search : INT[8] := [64, 0, 0, 0, 1, 0, 10, 10]', 'Search : INT[8] := [64, 0, 0, 0, 0, 400, 10, 10]', 'CPS(Search'),
    ('hold.steps', 'out-of-range', 'words 8434h 0034h 0 500', 'words 8434h 0034h 0 0', 'words 8434h'),
    ('hand_jogbits.py', 'out-of-range', 'CONFIGURE = (0x8434, 0x0034, 0, 500,', 'CONFIGURE = (0x8434, 0x0034, 0, 1500,', 'outputs[word] = value'),
    ('scaling_st.rung', 'integer-zero', 'Celsius := Raw * 150.0 / 16384.0;', 'Celsius := Raw * (150 / 16384);', '(150 / 16384)'),
    ('wait_homing.py', 'integer-zero', 'speed=900 + 100 * attempt', 'speed=900 + 1000 * (1 // 2)', '1 // 2'),
    ('hand_reversing.py', 'preset-unit', 'REST_NS = 1_500_000_000', 'REST_NS = 1_500', '>= REST_NS'),
    ('homing_st.rung', 'preset-unit', '{"PRE": 400}', '{"PRE": 2}', 'TONR(Wait)'),
    ('drillunit.rung', 'no-interlock', 'EQU(Step,20)OTE(FeedDown);\nEQU(Step,40)OTE(FeedUp);', '[EQU(Step,20),XIC(Cycle)]OTE(FeedDown);\n[EQU(Step,40),XIC(Clamped)]OTE(FeedUp);', 'OTE(FeedUp)'),
    ('reversing_st.rung', 'no-interlock', 'Forward := Dir > 0;\nReverse := Dir < 0;', 'Forward := FwdPB AND StopPB;\nReverse := RevPB AND StopPB;\nIF Dir > 5 THEN Dir := 0; END_IF;', 'Reverse := RevPB'),
    ('clamp_st.rung', 'no-interlock', 'CloseValve := Step = 10 OR Step = 20;\nOpenValve := Step = 30;', 'IF Go THEN CloseValve := 1; ELSE CloseValve := 0; END_IF;\nIF Opened THEN OpenValve := 0; ELSIF Closed THEN OpenValve := 1; END_IF;', 'OpenValve := 1'),
    ('debounce.rung', 'block-twice', 'XIO(Manual)JSR(Automatic,0);', 'XIO(Manual)JSR(Automatic,0);\nXIC(Sensor)JSR(Automatic,0);', 'TON(Kick'),
    ('wait_faults.py', 'block-twice', '        self.horn = self.fault\n', '        self.horn = self.fault or self.again()\n        self.fault = self.fault and not self.again()\n\n    def again(self) -> bool:\n        return self.pressed(self.reset)\n', 'return self.pressed'),
    ('hand_seal.py', 'never-waits', '    lamps.set_bit(0, 1, warmed)', '    lamps.set_bit(0, 1, warmed)\n    while not stop_ok:\n        lamps.set_bit(0, 0, False)', 'while not stop_ok'),
    ('wait_jog.py', 'never-waits', '            await until(lambda: self.right == self.left)\n', '            while self.axis.moving:\n                speed = 300\n', 'while self.axis'),
    ('batch_st.rung', 'never-waits', 'IF Count >= 12 THEN\n    Count := Count - 12;\n    Cases := Cases + 1;\nEND_IF;', 'WHILE Count >= 12 DO\n    Cases := Cases + 1;\nEND_WHILE;', 'WHILE Count'),
    ('hand_homing.py', 'never-waits', '            if status.AT_HOME:\n                axis.outputs[0] = 0', '            while not status.AT_HOME:\n                pass\n            if status.AT_HOME:\n                axis.outputs[0] = 0', 'while not status'),
]  # fmt: skip
"""Mistakes of all these kinds that were written when the rules were there already."""


def _planted(program: str, rule: str, old: str, new: str, at: str = "") -> Planted:
    return Planted(program, rule, old, new, at)


MISTAKES = [
    _planted(*each) for each in (*DROPPED, *REFUSED, *RANGES, *TWICE, *BOTH, *NUMBERS, *TIMES, *LOOPS, *FRESH)
]
"""The mistakes: the program, the rule that finds it, what is replaced by what, and the text of its line."""


@pytest.mark.slow
@pytest.mark.parametrize("name", IDIOMS)
def test_a_correct_program_has_no_findings(name, tmp_path):
    assert check(tmp_path, name, IDIOMS[name]).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda each: f"{each.program}-{each.rule}")
def test_a_mistake_is_found(mistake, tmp_path):
    assert mistake.old in IDIOMS[mistake.program]
    text = IDIOMS[mistake.program].replace(mistake.old, mistake.new, 1)
    first = (mistake.at or mistake.new).strip("\n").partition("\n")[0]
    line = next(number for number, each in enumerate(text.splitlines(), 1) if first in each)
    found = check(tmp_path, mistake.program, text).findings
    assert (mistake.rule, line) in [(each.rule, each.place.line) for each in found], found


def test_all_languages_have_programs():
    kinds = {
        "rungs": "ROUTINE Main\n",
        "text": "ROUTINE Main ST",
        "await": "await ",
        "by hand": "def logic(scan)",
    }
    for each in kinds.values():
        assert sum(each in text for text in IDIOMS.values()) >= 6
    assert sum(name.endswith(".steps") for name in IDIOMS) >= 6
    assert len(IDIOMS) >= 36
    assert len(MISTAKES) >= 50
