"""Correct structured text, and lists of steps, for `scanrack check`: none of them has a finding."""

# ruff: noqa: E501 - programs as a user writes them

from __future__ import annotations

AXIS = """\
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Step : DINT
"""
"""An axis whose words the program writes itself."""

READY = """\
0:
    COP(Setup[0], axis.O.Data[0], 8);
    IF axis.status.MODE_CONFIG AND NOT axis.status.CONFIG_ERROR THEN Step := 1; END_IF;
1:
    FOR I := 0 TO 7 DO axis.O.Data[I] := 0; END_FOR;
    IF NOT axis.status.MODE_CONFIG THEN Step := 2; END_IF;
2:
    axis.command.PRESET_POSITION := 1;
    IF NOT axis.status.POSITION_INVALID THEN
        axis.command.PRESET_POSITION := 0;
        Step := 10;
    END_IF;
"""
"""Steps 0 to 2: configured, and the position set."""


CLAMP = """\
PROGRAM clamp_st
ALIAS Go : Local:2:I.Data.0
ALIAS Closed : Local:2:I.Data.1
ALIAS Opened : Local:2:I.Data.2
ALIAS CloseValve : Local:3:O.Data.0
ALIAS OpenValve : Local:3:O.Data.1
TAG Step : DINT
TAG Hold : FBD_TIMER := {"PRE": 1200}
ROUTINE Main ST
CASE Step OF
0: IF Go AND Opened THEN Step := 10; END_IF;
10: IF Closed THEN Step := 20; END_IF;
20: IF Hold.DN THEN Step := 30; END_IF;
30: IF Opened AND NOT Go THEN Step := 0; END_IF;
ELSE
    Step := 30;
END_CASE;
Hold.TimerEnable := Step = 20;
TONR(Hold);
CloseValve := Step = 10 OR Step = 20;
OpenValve := Step = 30;
END
"""

JOG = f"""\
PROGRAM jog_st
{AXIS}ALIAS JogRight : Local:2:I.Data.0
ALIAS JogLeft : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
TAG I : DINT
ROUTINE Main ST
CASE Step OF
{READY}10:
    axis.O.Data[4] := 1;
    axis.O.Data[5] := 500;
    axis.O.Data[6] := 25;
    axis.O.Data[7] := 25;
    axis.command.MANUAL_CW := JogRight AND NOT JogLeft;
    axis.command.MANUAL_CCW := JogLeft AND NOT JogRight;
END_CASE;
Lamp := Step = 10;
END
"""

HOMING = """\
PROGRAM homing_st
SLOT axis : 1
TAG Setup : INT[8] := [16#8434, 16#0034, 0, 500, 0, 0, 0, 0]
TAG Search : INT[8] := [64, 0, 0, 0, 1, 200, 10, 10]
TAG Clear : INT[8] := [2048, 0, 0, 0, 0, 0, 0, 0]
TAG Nothing : INT[8] := [0, 0, 0, 0, 0, 0, 0, 0]
TAG Step : DINT
TAG Tries : DINT
TAG Wait : FBD_TIMER := {"PRE": 400}
ALIAS HomePB : Local:2:I.Data.0
ALIAS Homed : Local:3:O.Data.0
ALIAS Failed : Local:3:O.Data.1
ROUTINE Main ST
Wait.TimerEnable := Step = 40;
TONR(Wait);
CASE Step OF
0:
    COP(Setup[0], axis.O.Data[0], 8);
    IF axis.status.MODE_CONFIG AND NOT axis.status.CONFIG_ERROR THEN Step := 5; END_IF;
5:
    COP(Nothing[0], axis.O.Data[0], 8);
    IF NOT axis.status.MODE_CONFIG THEN Step := 10; END_IF;
10:
    Tries := 0;
    IF HomePB THEN Step := 20; END_IF;
20:
    COP(Search[0], axis.O.Data[0], 8);
    IF axis.status.AT_HOME THEN
        Step := 30;
    ELSIF axis.status.HOME_INVALID OR axis.status.COMMAND_ERROR THEN
        Tries := Tries + 1;
        Step := 40;
    END_IF;
30:
    axis.O.Data[0] := 0;
    IF HomePB THEN Step := 10; END_IF;
40:
    COP(Nothing[0], axis.O.Data[0], 8);
    IF Tries >= 3 THEN
        Step := 90;
    ELSIF Wait.DN THEN
        Step := 50;
    END_IF;
50:
    COP(Clear[0], axis.O.Data[0], 8);
    IF NOT axis.status.HOME_INVALID AND NOT axis.status.COMMAND_ERROR THEN Step := 55; END_IF;
55:
    COP(Nothing[0], axis.O.Data[0], 8);
    IF axis.status.MODULE_OK THEN Step := 20; END_IF;
90:
    IF HomePB THEN Tries := 0; Step := 50; END_IF;
END_CASE;
Homed := Step = 30;
Failed := Step = 90;
END
"""


REVERSING = """\
PROGRAM reversing_st
ALIAS FwdPB : Local:2:I.Data.0
ALIAS RevPB : Local:2:I.Data.1
ALIAS StopPB : Local:2:I.Data.2
ALIAS Forward : Local:3:O.Data.0
ALIAS Reverse : Local:3:O.Data.1
TAG Rest : FBD_TIMER := {"PRE": 1000}
TAG Dir : DINT
ROUTINE Main ST
Rest.TimerEnable := Dir = 0;
TONR(Rest);
IF NOT StopPB THEN
    Dir := 0;
ELSIF FwdPB AND NOT RevPB AND Rest.DN THEN
    Dir := 1;
ELSIF RevPB AND NOT FwdPB AND Rest.DN THEN
    Dir := -1;
END_IF;
Forward := Dir > 0;
Reverse := Dir < 0;
END
"""

TABLE = f"""\
PROGRAM table_st
{AXIS}ALIAS Next : Local:2:I.Data.0
ALIAS Busy : Local:3:O.Data.0
TAG I : DINT
TAG At : DINT
TAG Target : DINT
TAG Before : BOOL
TAG Stops : DINT[3] := [1500, -1500, 0]
TAG Speeds : DINT[3] := [2500, 2500, 6000]
ROUTINE Main ST
CASE Step OF
{READY}10:
    IF Next AND NOT Before THEN
        At := (At + 1) MOD 3;
        Target := Stops[At];
        axis.O.Data[2] := Target / 1000;
        axis.O.Data[3] := Target MOD 1000;
        axis.O.Data[4] := Speeds[At] / 1000;
        axis.O.Data[5] := Speeds[At] MOD 1000;
        axis.O.Data[6] := 20;
        axis.O.Data[7] := 20;
        Step := 20;
    END_IF;
20:
    axis.O.Data[0] := 1;
    IF axis.status.MOVING_CW OR axis.status.MOVING_CCW THEN Step := 30; END_IF;
30:
    axis.O.Data[0] := 0;
    IF axis.status.MOVE_COMPLETE THEN Step := 10; END_IF;
END_CASE;
Before := Next;
Busy := Step >= 20;
END
"""

SCALING = """\
PROGRAM scaling_st
ALIAS Heater : Local:3:O.Data.0
ALIAS Alarm : Local:3:O.Data.1
TAG Raw : INT
TAG Celsius : REAL
TAG Percent : DINT
TAG SP_Low : REAL := 58.5
TAG SP_High : REAL := 61.5
TAG Heating : BOOL
ROUTINE Main ST
Raw := Local:2:I.Data[0];
Celsius := Raw * 150.0 / 16384.0;
Percent := Raw * 100 / 16384;
IF Celsius < SP_Low THEN
    Heating := 1;
ELSIF Celsius > SP_High THEN
    Heating := 0;
END_IF;
Heater := Heating;
Alarm := Percent > 60 OR Percent < 5;
END
"""

BATCH = """\
PROGRAM batch_st
ALIAS Photo : Local:2:I.Data.0
ALIAS Clear : Local:2:I.Data.1
ALIAS Full : Local:3:O.Data.0
TAG Count : DINT
TAG Cases : DINT
TAG Layer : DINT
TAG Before : BOOL
ROUTINE Main ST
IF Photo AND NOT Before THEN Count := Count + 1; END_IF;
Before := Photo;
IF Count >= 12 THEN
    Count := Count - 12;
    Cases := Cases + 1;
END_IF;
Layer := Cases / 4 MOD 5;
Full := Layer = 4;
IF Clear THEN Count := 0; Cases := 0; END_IF;
END
"""


TEXT = {
    "clamp_st.rung": CLAMP,
    "jog_st.rung": JOG,
    "homing_st.rung": HOMING,
    "reversing_st.rung": REVERSING,
    "table_st.rung": TABLE,
    "scaling_st.rung": SCALING,
    "batch_st.rung": BATCH,
}
"""Structured text by name."""

CONFIGURED = """\
words 8434h 0034h 0 500    until MODE_CONFIG -CONFIG_ERROR
zero                       until -MODE_CONFIG
"""

STEPS = {
    "outback.steps": f"""\
# out and back, from home
{CONFIGURED}FIND_HOME_CCW speed 1000 acceleration 10 deceleration 10    until AT_HOME -POSITION_INVALID
idle                       for 20 ms
ABSOLUTE_MOVE target 4000 speed 5000 acceleration 10 deceleration 10    until MOVE_COMPLETE
idle                       for 1000 ms
ABSOLUTE_MOVE target -1250 speed 5000 acceleration 10 deceleration 10    until MOVE_COMPLETE
idle
""",
    "preset.steps": f"""\
{CONFIGURED}PRESET_POSITION target -12345    until -POSITION_INVALID
zero                       for 4 ms
RELATIVE_MOVE target 2500 speed 3000 acceleration 20 deceleration 40    until MOVE_COMPLETE
zero                       for 100 ms
RELATIVE_MOVE target -2500 speed 3000 acceleration 20 deceleration 40    until MOVE_COMPLETE
zero
""",
    "jog.steps": f"""\
{CONFIGURED}MANUAL_CW speed 800 acceleration 10 deceleration 10    for 2 s
idle                       until STOPPED
MANUAL_CCW speed 300 acceleration 10 deceleration 10    for 1 s
idle                       until STOPPED
""",
    "hold.steps": f"""\
SLOT 4
{CONFIGURED}PRESET_POSITION            until -POSITION_INVALID
idle                       for 10 ms
ABSOLUTE_MOVE target 8000 speed 2000 acceleration 10 deceleration 10    for 1 s
HOLD_MOVE speed 2000 acceleration 10 deceleration 10    until HOLD_STATE
RESUME_MOVE speed 4000 acceleration 10 deceleration 10    until MOVE_COMPLETE
idle
""",
    "recover.steps": f"""\
{CONFIGURED}FIND_HOME_CW speed 700 acceleration 10 deceleration 10    until AT_HOME
idle                       for 20 ms
MANUAL_CW speed 3000 acceleration 10 deceleration 10    until INPUT_ERROR
idle                       for 20 ms
RESET_ERRORS               until -INPUT_ERROR
idle                       for 20 ms
MANUAL_CCW speed 1000 acceleration 10 deceleration 10    for 2 s
idle                       until STOPPED
FIND_HOME_CCW speed 700 acceleration 10 deceleration 10    until AT_HOME
idle
""",
    "curve.steps": f"""\
{CONFIGURED}PRESET_POSITION            until -POSITION_INVALID
zero                       for 4 ms
ABSOLUTE_MOVE S_CURVE TRAPEZOIDAL target 6000 speed 9000 acceleration 15 deceleration 15    until MOVE_COMPLETE
idle                       for 4 ms
IMMEDIATE_STOP             for 4 ms
zero
""",
}
"""Lists of steps by name."""
