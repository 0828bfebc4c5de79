"""Questions why, with causes that were planted: worlds, what is done in them, what is asked.

What is done is written as in `tests/support/chain_text.py`, a word or a pair at a time:

    1s              run for that time              hold start / drop start     an input of the panel
    press start     60 ms, then it is let go       force Run=0, free Run       see `Bench.force`
    set Auto=1      a tag                          key program, key run        the CPU's key
    fail 1=removed  trouble of a module; `fail 1` ends it                     cycle 1   power off and on

A row names the kind of the last link, and words of the last line of the answer.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from scanrack import open_bench
from scanrack.runtime.loop.faults import CpuFault

EXAMPLES = Path(__file__).parents[2] / "examples"

PANEL = """scan_ms = 10
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
switches = [{ input = "home", first = -300, last = -100 }, { input = "cw_limit", first = 90000 }]
[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { start = 0, stop = 1, guard = 2, reset = 3, part = 4, sel = 5 }
normally_closed = ["stop"]
[[slot]]
number = 3
module = "1769-OB16"
"""
RUNGS = """PROGRAM line
TAG Run : BOOL
TAG Lamp : BOOL
TAG Horn : BOOL
TAG Late : BOOL
TAG T : TIMER
TAG Parts : COUNTER
TAG Full : BOOL
TAG Jam : BOOL
TAG Recipe : INT[4] := [300, 800, 0, 0]
TAG Sel : INT
TAG Speed : INT
TAG Fast : BOOL
TAG Auto : BOOL
TAG Cycle : BOOL
TAG Once : BOOL
TAG Edge : BOOL
TAG Count : DINT
TAG Lock : BOOL
TAG At : DINT
TAG Cell : INT[4]
TAG Mode : DINT
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Guard : Local:2:I.Data.2
ALIAS Reset : Local:2:I.Data.3
ALIAS Part : Local:2:I.Data.4
ALIAS Select : Local:2:I.Data.5
ALIAS Beacon : Local:3:O.Data.0
SLOT axis : 1
ROUTINE Main
[XIC(Start),XIC(Run)]XIC(Stop)OTE(Run);
XIC(Run)XIC(Guard)OTE(Lamp);
XIC(Run)TON(T,1000,0);
XIC(T.DN)OTE(Late);
XIC(Part)CTU(Parts,3,0);
XIC(Parts.DN)OTE(Full);
XIC(Full)OTL(Jam);
XIC(Reset)RES(Parts)OTU(Jam);
XIC(Jam)OTE(Horn);
XIC(Run)MOV(Recipe[Sel],Speed);
GRT(Speed,500)OTE(Fast);
XIC(Auto)XIC(Run)OTE(Cycle);
XIC(Start)ONS(Once)OTE(Edge);
XIC(Edge)XIO(Lock)ADD(Count,1,Count);
XIC(Select)MOV(9,At);
MOV(1,Cell[At]);
MOV(1,Mode);
XIC(Jam)MOV(4,Mode);
XIC(Lamp)OTE(Beacon);
END
"""
TEXT = """PROGRAM line
TAG Run : BOOL
TAG Lamp : BOOL
TAG Level : DINT
TAG High : BOOL
TAG Step : DINT
TAG T : FBD_TIMER
TAG Rest : BOOL
ALIAS Start : Local:2:I.Data.0
ALIAS Stop : Local:2:I.Data.1
ALIAS Guard : Local:2:I.Data.2
ALIAS Part : Local:2:I.Data.4
ROUTINE Main ST
Run := (Start OR Run) AND Stop;
IF Run AND Guard THEN
    Lamp := 1;
ELSE
    Lamp := 0;
END_IF;
IF Part THEN
    Level := Level + 1;
END_IF;
High := Level > 20;
CASE Step OF
    0: IF Run THEN Step := 1; END_IF;
    1: IF Guard THEN Step := 2; END_IF;
END_CASE;
END
"""
PYTHON = """
from scanrack import Configuration, Direction, Idle, InputBit, Manual

CONFIGURE = Configuration(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, starting_speed=1000).to_image()
JOG = Manual(Direction.CW, 5000, 20, 10).to_image()


class State:
    run = False
    lamp = False
    parts = 0
    part = False


state = State()


def logic(scan):
    inputs, out = scan.slot[2].inputs, scan.slot[3].outputs
    axis = scan.slot[1].outputs
    if scan.number == 0:
        axis.load(CONFIGURE)
    elif scan.number == 3:
        axis.load(Idle().to_image())
    if inputs.bit(0, 0):
        state.run = True
    if not inputs.bit(0, 1):
        state.run = False
    if scan.number > 5:
        axis.load(JOG if state.run else Idle().to_image())
    if inputs.bit(0, 4) and not state.part:
        state.parts += 1
    state.part = inputs.bit(0, 4)
    state.lamp = state.run and inputs.bit(0, 2)
    out[0] = 1 if state.lamp else 0
"""
SEQUENCE = """
from scanrack import Axis3601, Configuration, Input, InputBit, Logic, Output, dwell, sequence

USED = InputBit.HOME | InputBit.CW_LIMIT
RATES = {"speed": 5000, "acceleration": 100, "deceleration": 100}


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))
    start = Input("slot2.input.start")
    guard = Input("slot2.input.guard")
    part = Input("slot2.input.part")
    lamp = Output("Local:3:O.Data.0")
    horn = Output("Local:3:O.Data.1")
    rounds = 0

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        while True:
            await self.start.rises
            await self.axis.move_to(2000, **RATES)
            self.lamp = True
            await dwell("2 s")
            self.lamp = False
            await self.axis.move_to(0, **RATES)
            self.rounds += 1

    @sequence
    async def door(self) -> None:
        await self.guard.on
        self.horn = True
"""
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
scan_ms = 10
[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { start = 0 }
timeline = [{ at_ms = 310, input = "start" }]
"""
TWO = """PROGRAM two
TAG Far : DINT
TAG Lamp : BOOL
ROUTINE Main
EQU(Far,5)OTE(Lamp);
END
"""
TASKS = """CONTROLLER c
TAG Begin : BOOL
TAG Run : BOOL
TAG Lamp : BOOL
TAG N : DINT
ALIAS Start : Local:2:I.Data.0
TASK Fast : PERIODIC 30 ms RUNS One
TASK Cycle : CONTINUOUS RUNS Two
PROGRAM One MAIN Main
ROUTINE Main
XIC(Start)OTL(Run);
ADD(N,1,N);
END
END PROGRAM
PROGRAM Two MAIN Main
TAG Allowed : BOOL
ROUTINE Main
XIC(Run)XIC(Allowed)OTE(Lamp);
END
END PROGRAM
"""
BROKEN = (EXAMPLES / "feeder" / "feeder.rung").read_text("utf-8").replace("16#003C, 0, 500", "16#003C, 0, 0")
"""The feeder with a starting speed of 0, which CFG refuses."""

FEEDER = (EXAMPLES / "feeder" / "feeder.toml").read_text("utf-8")

WORLDS: Mapping[str, Mapping[str, str]] = {
    "rungs": {"line.rung": RUNGS, "rack.toml": f'program = "line.rung"\n{PANEL}'},
    "text": {"line.rung": TEXT, "rack.toml": f'program = "line.rung"\n{PANEL}'},
    "python": {"line.py": PYTHON, "rack.toml": f'program = "line.py"\n{PANEL}'},
    "sequence": {"line.py": SEQUENCE, "rack.toml": f'program = "line.py"\n{PANEL}'},
    "tasks": {"line.rung": TASKS, "rack.toml": f'program = "line.rung"\n{PANEL}'},
    "two racks": {
        "one.rung": ONE, "one.toml": ONE_RACK, "two.rung": TWO,
        "rack.toml": f'program = "two.rung"\n{PANEL}'
        '[stubs]\nFar = { rack = "one.toml", tag = "Count", rpi_ms = 20 }\n',
    },
    "feeder": {
        "feeder.rung": (EXAMPLES / "feeder" / "feeder.rung").read_text("utf-8"), "rack.toml": FEEDER,
    },
    "wrong configuration": {"feeder.rung": BROKEN, "rack.toml": FEEDER},
    **{
        rack: {
            name: (EXAMPLES / "sequences" / file).read_text("utf-8")
            for name, file in (("stations.py", "stations.py"), ("rack.toml", f"{rack}.toml"))
        }
        for rack in ("stations", "stations_pcl601")
    },
    "line": {
        name: (EXAMPLES / "three_stations_panel" / file).read_text("utf-8")
        for name, file in (("line.rung", "line.rung"), ("rack.toml", "line.toml"))
    },
}  # fmt: skip


class Question(NamedTuple):
    """A question and its planted cause."""

    group: str
    world: str
    done: str
    asked: str
    kind: str  # of the last link
    words: tuple[str, ...]  # in the last line


def _rows(group: str, world: str, *rows: tuple[str, str, str, str]) -> list[Question]:
    return [
        Question(group, world, done, asked, kind, tuple(words.split("|")))
        for done, asked, kind, words in rows
    ]


QUESTIONS = [
    *_rows("never on", "rungs",
        ("1s", "Run", "input", "Start|never"),
        ("1s press start 1s", "Lamp", "input", "Guard|never"),
        ("1s", "Horn", "input", "Part|never"),
        ("1s press start 1s", "Cycle", "operator", "Auto|never|no rung writes"),
        ("1s press start 500ms", "Late", "timer", "T|of 1 s|done in"),
        ("1s press part 100ms press part 1s", "Full", "timer", "Parts|2 of 3"),
        ("1s press start 1s", "Fast", "setting", "Recipe|300"),
        ("1s", "Beacon", "input", "Guard|never"),
    ),
    *_rows("never on", "text",
        ("1s", "Run", "input", "Start|never"),
        ("1s press start 1s", "Lamp", "input", "Guard|never"),
        ("1s press start 1s", "Step", "input", "Start"),
        ("1s", "High", "input", "Part|never"),
    ),
    *_rows("never on", "python",
        ("1s", "state.run", "input", "start|never"),
        ("1s press start 1s", "state.lamp", "input", "guard|never"),
        ("1s", "state.parts", "input", "part|never"),
    ),
    *_rows("never on", "sequence",
        ("1s", "lamp", "input", "start|never"),
        ("1s", "horn", "input", "guard|never"),
    ),
    *_rows("never on", "tasks",
        ("1s press start 1s", "Lamp", "operator", "Allowed|never|no rung writes"),
        ("1s", "Run", "input", "Start|never"),
    ),
    *_rows("never on", "wrong configuration",
        ("2s", "Feeding", "module", "starting speed|CFG"),
        ("2s", "Configure.Done", "module", "starting speed|CFG"),
    ),
    *_rows("never off", "rungs",
        ("1s press start 1s", "Run", "input", "Start"),
        ("1s press part 1s press part 1s press part 1s", "Jam", "input", "Part"),
        ("100ms", "Stop", "input", "Stop"),
    ),
    *_rows("cut short", "stations",
        ("14.2s", "lamp", "input", "IN_ESTOP"),
        ("14.2s", "slot1.status.MOVING_CCW", "input", "IN_ESTOP"),
        ("30s", "lamp", "input", "start"),
    ),
    *_rows("cut short", "stations_pcl601",
        ("14.2s", "lamp", "input", "IN_ESTOP"),  # STOPPED shows scans after the emergency stop
        ("14.2s", "slot1.status.STOPPED", "input", "IN_ESTOP"),
    ),
    *_rows("cut short", "feeder",
        ("8.2s", "Feeding", "input", "IN_ESTOP"),
        ("6s key program 100ms", "slot1.status.MOVING_CW", "mode", "program mode|since 6"),
        ("6s key program 500ms key run 500ms", "Trouble", "mode", "at program since 6"),
    ),
    *_rows("cut short", "python",
        ("1s press start 20s", "slot1.status.MOVING_CW", "input", "CW_LIMIT"),
    ),
    *_rows("plain", "rungs",
        ("1s press start 1s drop stop 1s", "Run", "input", "Stop"),
        ("1s press start 2s", "Late", "input", "Start"),
        ("1s press start 1s hold guard 1s drop stop 100ms", "Beacon", "input", "Stop"),
        ("1s set Auto=1 1s press start 1s", "Cycle", "input", "Start"),
        ("1s press start 1s set Auto=1 1s", "Cycle", "operator", "Auto"),
        ("1s set Sel=1 press start 1s", "Fast", "input", "Start"),
        ("1s press part 1s press part 1s press part 1s press reset 1s", "Horn", "input", "Reset"),
    ),
    *_rows("missed edge", "rungs",
        ("1s set Lock=1 1s press start 1s", "Count", "operator", "Lock"),
        ("1s hold start 1s", "Edge", "input", "Start"),
    ),
    *_rows("plain", "text",
        ("1s press start 1s drop stop 1s", "Run", "input", "Stop"),
        ("1s press start hold guard 1s", "Lamp", "input", "Guard"),
        ("1s hold part 1s", "High", "input", "Part"),
    ),
    *_rows("plain", "python",
        ("1s press start 1s drop stop 1s", "state.run", "input", "stop"),
        ("1s press start 1s", "slot1.status.MOVING_CW", "input", "start"),
        ("1s press start 1s", "slot1.command.MANUAL_CW", "input", "start"),
    ),
    *_rows("plain", "sequence",
        ("1s press start 2s", "lamp", "input", "start"),
        ("1s press start 1s", "slot1.status.MOVING_CW", "input", "start"),
    ),
    *_rows("plain", "two racks", ("1s", "Lamp", "input", "Start|one.toml")),
    *_rows("outranked", "rungs",
        ("1s press start 1s force Run=0 1s", "Lamp", "force", "Run|forced to 0|since"),
        ("1s force slot2.input.guard=0 press start hold guard 1s", "Lamp", "force", "forced to 0|since"),
        ("1s force Local:3:O.Data.0=1 1s", "Beacon", "force", "forced to 1|since"),
        ("1s press start 1s key program 1s", "Run", "mode", "program mode|since"),
        ("1s press start 1s key program 1s", "Local:3:O.Data.0", "mode", "program mode|since"),
        ("1s press start 1s key program 1s key run 1s", "Run", "mode", "run mode|at program since 2.0"),
        ("1s key program 1s key run 1s press start 1s", "Run", "input", "Start"),
        ("1s press start 1s hold sel 1s", "Beacon", "fault", "fault"),
        ("1s press start 1s hold sel 1s", "Run", "input", "Start"),
        ("1s fail 1=link-lost 1s", "axis.status.MODULE_OK", "incident", "link lost since"),
    ),
    *_rows("outranked", "python",
        ("1s press start 1s force Local:3:O.Data.0=1 1s", "Local:3:O.Data.0", "force", "forced to 1|since"),
        ("1s press start 1s fail 1=link-lost 1s", "slot1.status.MOVING_CW", "incident", "link lost"),
        ("1s press start 1s cycle 1 1s", "slot1.status.CONFIG_ERROR", "incident", "power"),
        ("1s press start 1s fail 1=removed 1s", "slot1.status.MODULE_OK", "incident", "removed"),
    ),
    *_rows("outranked", "sequence",
        ("1s press start 1s fail 1=link-lost 2s", "cycle", "incident", "link lost"),
    ),
    *_rows("block", "feeder",
        ("8.3s", "Axis.State", "input", "IN_ESTOP|8.002 s"),
        ("8.3s", "Homing", "input", "IN_ESTOP|8.002 s"),
        ("9s", "Quiet.DN", "timer", "Quiet|done in"),
        ("12s", "Trouble", "input", "IN_ESTOP|8.5"),
        ("1s", "Feeding", "module", "busy|FIND_HOME"),
        ("12s", "Axis.State", "input", "IN_HOME"),
    ),
    *_rows("block", "wrong configuration", ("2s", "Configure.Error", "module", "starting speed|CFG")),
    *_rows("round", "line",
        ("4.4s", "Going", "input", "IN_HOME"),  # what began the rounds
        ("400ms", "Run", "input", "Start|never"),
        ("400ms", "Going", "input", "Start|never"),
        ("9.5s", "Run", "input", "Stop|9 s"),
    ),
    *_rows("missed edge", "sequence",
        ("1s press start 1s press start 4s", "cycle", "input", "start|rose|needs a new rise"),
    ),
]  # fmt: skip


def make(folder: Path, world: str) -> Any:
    """Write the files of a world, and open its bench."""
    for name, text in WORLDS[world].items():
        (folder / name).write_text(text, encoding="utf-8")
    return open_bench(folder / "rack.toml")


def do(bench: Any, done: str) -> None:
    """Do what is done."""
    words = iter(done.split())
    for word in words:
        if word[0].isdigit():
            try:
                bench.run_for(word)
            except CpuFault:
                return
            continue
        name, given, value = next(words).partition("=")
        if word == "press":
            bench.slot[2].press(name, "60 ms")
        elif word in ("hold", "drop"):
            bench.slot[2].set_input(name, word == "hold")
        elif word == "force":
            bench.force(name, int(value))
        elif word == "free":
            bench.unforce(name)
        elif word == "set":
            bench[name] = int(value)
        elif word == "key":
            bench.program_mode() if name == "program" else bench.run_mode()
        elif word == "fail":
            bench.slot[int(name)].inject(value if given else None)
        elif word == "cycle":
            bench.slot[int(name)].power_cycle()
        else:
            raise ValueError(f"{word}: nothing is known that is done so")
