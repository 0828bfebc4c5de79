"""Chains of causes through tasks, programs and charts, expected by hand from their rules.

Scans are 10 ms apart. Due tasks run before the continuous one; one of 30 ms runs in scans 0, 3, 6.
An event task runs before the scan after the EVENT. The actions of a step run in the scan after the one that
activates it.
"""

import pytest
from chain_text import after, text_of
from charts import BATCH
from charts import program_of as chart_of
from scanrack.ladder.files import parse_program

TEXT = """CONTROLLER c
TAG Start : BOOL
TAG Run : BOOL
TAG Lamp : BOOL
TAG N : DINT
{tasks}
PROGRAM One MAIN Main
TAG Own : BOOL
TAG Seen : BOOL
ROUTINE Main
XIC(Start)OTE(Own);
XIC(Own)OTE(Run);
{one}
END
END PROGRAM
PROGRAM Two MAIN Main
TAG Own : BOOL
ROUTINE Main
{two}
END
END PROGRAM
"""
LAMP = "XIC(Run)OTE(Lamp);"
BOTH = "TASK Cycle : CONTINUOUS RUNS One, Two"
OTHER_ORDER = "TASK Cycle : CONTINUOUS RUNS Two, One"
FAST_ONE = "TASK Fast : PERIODIC 30 ms RUNS One\nTASK Cycle : CONTINUOUS RUNS Two"
FAST_TWO = "TASK Fast : PERIODIC 30 ms RUNS Two\nTASK Cycle : CONTINUOUS RUNS One"
EVENT_TWO = "TASK Alarm : EVENT RUNS Two\nTASK Cycle : CONTINUOUS RUNS One"
ONCE = "XIC(Start)ONS(Seen)EVENT(Alarm);"

ROWS = {
    "two programs": (
        BOTH, "", LAMP, "2 Start 2", "Lamp", "Lamp on @2 < Run on @2 < Own on @2 < Start on @2 operator",
    ),
    "the reader runs first": (
        OTHER_ORDER, "", LAMP, "2 Start 3", "Lamp",
        "Lamp on @3 < Run on @2 < Own on @2 < Start on @2 operator",
    ),
    "a periodic task": (
        FAST_ONE, "", LAMP, "4 Start 6", "Lamp", "Lamp on @6 < Run on @6 < Own on @6 < Start on @4 operator",
    ),
    "a periodic task, off": (
        FAST_ONE, "", LAMP, "4 Start 4 -Start 6", "Lamp",
        "Lamp off @9 < Run off @9 < Own off @9 < Start off @8 operator",
    ),
    "the reader is the periodic task": (
        FAST_TWO, "", LAMP, "4 Start 6", "Lamp", "Lamp on @6 < Run on @4 < Own on @4 < Start on @4 operator",
    ),
    "a rung without conditions": (FAST_TWO, "", "ADD(N,1,N);", "5", "N", "N = 2 @3 < task Fast @3 task"),
    "a task that EVENT triggers": (
        EVENT_TWO, ONCE, "ADD(N,1,N);", "2 Start 4", "N",
        "N = 1 @3 < task Alarm on @2 < Start on @2 operator",
    ),
    "a tag of a program": (
        BOTH, "", LAMP, "2 Start 2", "\\One.Own", "\\One.Own on @2 < Start on @2 operator",
    ),
    "a tag of the same name in the other program": (
        BOTH, "", "XIC(\\One.Own)OTE(Own);", "2 Start 2", "\\Two.Own",
        "\\Two.Own on @2 < \\One.Own on @2 < Start on @2 operator",
    ),
    "tags of two programs, needed both": (
        BOTH, "", "XIC(Run)XIC(\\One.Own)OTE(Lamp);", "2 Start 2", "Lamp",
        "Lamp on @2 < Own on @2 < Start on @2 operator & Run on @2 < Own on @2 < Start on @2 operator",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ROWS)
def test_tasks_and_programs(name):
    tasks, one, two, done, tag, expected = ROWS[name]
    program = parse_program(TEXT.format(tasks=tasks, one=one, two=two))
    assert text_of(after(program, done).chain(tag)) == expected


# Full is on in scan 2: T0 ends Idle there, Fill begins. Its time is 0 in its first execution, in scan 3, and
# 50 ms in scan 8
FILLED = "Fill.X on @2 < T0 on @2 < Full on @2 operator"
CHARTS = {
    "a step": ("2 Full 3", "Fill.X", FILLED),
    "an action's statement": ("2 Full 3", "Valve", f"Valve on @3 < {FILLED}"),
    "a stored action": ("2 Full 3", "Stir.Q", f"Stir.Q on @3 < {FILLED}"),
    "a step after a time": (
        "2 Full 7", "Drain.X", f"Drain.X on @8 < T1 on @8 < Fill.DN on @8 < {FILLED}",
    ),
    "an action that another step ends": (
        "2 Full 8", "Stir.Q", f"Stir.Q off @9 < Drain.X on @8 < T1 on @8 < Fill.DN on @8 < {FILLED}",
    ),
    "the initial step": ("2", "Idle.X", "Idle.X on @0 < power-up @0"),
}  # fmt: skip


@pytest.mark.parametrize("name", CHARTS)
def test_charts(name):
    done, tag, expected = CHARTS[name]
    program = chart_of(BATCH, tags="Full : BOOL; Valve : BOOL")
    assert text_of(after(program, f"Fill.PRE=50 {done}").chain(tag)) == expected
