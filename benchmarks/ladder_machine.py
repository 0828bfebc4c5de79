"""A machine's program, as real ones are: branches, timers, counters, compares, copies, scaling and blocks.

    python benchmarks/ladder_machine.py            ns per rung of 20 stations, memory of 10,000 rungs
    python benchmarks/ladder_machine.py --smoke    2 stations and 1,000 rungs: a short run that only checks

A station has 36 rungs: a sequence of steps, latched faults, counters, a recipe by COP, scaling in REAL, and
two valves, instances of an add-on instruction of six rungs. A call counts as a rung, and the rungs of its
block as six more, since a scan executes them.

Checked: compiled and interpreted end in the same memory, and every station has made the parts of its script.
The memory is the highest of a process of its own, which builds the ten rungs of ladder.py.
"""

from __future__ import annotations

import argparse
import subprocess
import sys

from bars import Bars, highest_mib
from scanrack.ladder.files.rungfile import parse_program
from scanrack.ladder.run.engine import Engine

from ladder import RUNGS, TIMED_OUT_NS, per_call
from ladder import program as ten_rungs

PERIOD_MS = 10
RUNG_BAR_NS = 78
MEMORY_BAR_MIB = 300

HEAD = """PROGRAM machine
TYPE Recipe (Speed : DINT, Dwell : DINT, Parts : DINT, Scale : REAL)
INSTRUCTION Valve
INPUT Open : BOOL REQUIRED
INPUT AtOpen : BOOL REQUIRED
INPUT AtClosed : BOOL REQUIRED
OUTPUT Coil : BOOL REQUIRED
OUTPUT Fault : BOOL REQUIRED
LOCAL Late : TIMER := {"PRE": 200}
LOCAL Strokes : DINT
LOCAL Edge : BOOL
ROUTINE Logic
XIC(Open)XIO(Fault)OTE(Coil);
[XIC(Coil)XIO(AtOpen),XIO(Coil)XIO(AtClosed)]TON(Late,?,?);
XIC(Late.DN)OTL(Fault);
XIO(Open)XIC(AtClosed)OTU(Fault);
XIC(AtOpen)ONS(Edge)ADD(Strokes,1,Strokes);
GRT(Strokes,1000000)MOV(0,Strokes);
END
END INSTRUCTION
TAG Recipes : Recipe[4] := [{"Speed": 1000, "Dwell": 30, "Parts": 5, "Scale": 0.5}]
TAG Active : DINT
TAG Reset : BOOL
TAG Ready : BOOL
TAG Guard : BOOL"""

STATION = """BOOL Auto, Start, Stop, Running, Fault, Ack, Home, PartIn, PartOut, Full, Lamp, Horn, Clamp, Lift
BOOL ClampAt, ClampBack, LiftAt, LiftBack, OpenClamp, OpenLift, ClampFault, LiftFault, Once, Edge, Low, High
DINT Step, Good, Bad, Raw, Level, Target, Code
REAL Value, Filtered
TIMER Dwell, Watch, Blink
COUNTER Parts, Batches
Recipe Own
Valve ClampValve, LiftValve"""

LOGIC = """XIC(Guard)XIC(Auto{0})[XIC(Start{0}),XIC(Running{0})]XIO(Stop{0})XIO(Fault{0})OTE(Running{0});
XIC(Running{0})ONS(Once{0})COP(Recipes[Active],Own{0},1);
XIO(Running{0})MOV(0,Step{0});
XIC(Running{0})EQU(Step{0},0)XIC(Home{0})MOV(10,Step{0});
EQU(Step{0},10)XIC(PartIn{0})MOV(20,Step{0});
EQU(Step{0},20)XIC(ClampAt{0})MOV(30,Step{0});
EQU(Step{0},30)XIC(LiftAt{0})XIC(Dwell{0}.DN)MOV(40,Step{0});
EQU(Step{0},40)XIC(LiftBack{0})XIC(ClampBack{0})MOV(10,Step{0});
[EQU(Step{0},20),EQU(Step{0},30)]OTE(OpenClamp{0});
EQU(Step{0},30)OTE(OpenLift{0});
EQU(Step{0},30)XIC(LiftAt{0})TON(Dwell{0},30,0);
Valve(ClampValve{0},OpenClamp{0},ClampAt{0},ClampBack{0},Clamp{0},ClampFault{0});
Valve(LiftValve{0},OpenLift{0},LiftAt{0},LiftBack{0},Lift{0},LiftFault{0});
EQU(Step{0},40)XIC(PartOut{0})CTU(Parts{0},5,0);
GEQ(Parts{0}.ACC,Own{0}.Parts)[OTE(Full{0}),CTU(Batches{0},100,0)];
XIC(Full{0})XIC(Ack{0})RES(Parts{0});
XIC(Running{0})NEQ(Step{0},10)TON(Watch{0},5000,0);
[XIC(Watch{0}.DN),XIC(ClampFault{0}),XIC(LiftFault{0})]OTL(Fault{0});
XIC(Reset)[XIC(Ack{0}),XIO(Auto{0})]OTU(Fault{0});
XIC(ClampFault{0})MOV(1,Code{0});
XIC(LiftFault{0})MOV(2,Code{0});
XIC(Watch{0}.DN)XIO(ClampFault{0})XIO(LiftFault{0})MOV(3,Code{0});
XIO(Fault{0})CLR(Code{0});
XIO(Blink{0}.DN)TON(Blink{0},250,0);
LES(Blink{0}.ACC,125)[XIC(Fault{0}),XIC(Full{0})]OTE(Lamp{0});
XIC(Fault{0})XIO(Ack{0})OTE(Horn{0});
MUL(Raw{0},Own{0}.Scale,Value{0});
CPT(Filtered{0},Filtered{0}*0.75+Value{0}*0.25);
LIM(0,Raw{0},4095)MOV(Raw{0},Level{0});
LES(Level{0},200)OTE(Low{0});
GRT(Level{0},3800)OTE(High{0});
XIC(Low{0})XIO(High{0})SUB(Own{0}.Speed,100,Target{0});
XIO(Low{0})MOV(Own{0}.Speed,Target{0});
XIC(PartOut{0})ONS(Edge{0})[XIO(Fault{0})ADD(Good{0},1,Good{0}),XIC(Fault{0})ADD(Bad{0},1,Bad{0})];
XIC(Auto{0})XIO(Fault{0})XIC(Ready)OTE(Home{0});
EQU(Step{0},10)XIO(Full{0})[XIC(PartIn{0}),XIC(Start{0}),XIO(Guard)]NOP();"""

BLOCK_RUNGS, CALLS = 6, 2
PARTS = 3
PART: tuple[tuple[dict[str, object], int], ...] = (
    ({"PartIn": True, "PartOut": False}, 2),
    ({"ClampAt": True, "ClampBack": False}, 2),
    ({"LiftAt": True, "LiftBack": False}, 5),
    ({"LiftAt": False, "LiftBack": True, "PartIn": False, "PartOut": True}, 1),
    ({"ClampAt": False, "ClampBack": True}, 1),
)
"""What is set at a station for one part, and for how many scans more."""


def program(stations: int) -> str:
    """Return the text of a machine of so many stations."""
    tags = [
        f"TAG {name.strip()}{number} : {kind}"
        for number in range(stations)
        for kind, _, names in (line.partition(" ") for line in STATION.splitlines())
        for name in names.split(",")
    ]
    logic = [rung.format(number) for number in range(stations) for rung in LOGIC.splitlines()]
    return "\n".join([HEAD, *tags, "ROUTINE Main", "XIC(Guard)OTE(Ready);", *logic, "END"])


def rungs(stations: int) -> int:
    """Return how many rungs a scan executes, those of the blocks included."""
    return 1 + stations * (len(LOGIC.splitlines()) + CALLS * BLOCK_RUNGS)


def played(engine: Engine, stations: int) -> Engine:
    """Bring some parts through all stations."""
    start: dict[str, object] = {"Auto": True, "Start": True, "ClampBack": True, "LiftBack": True, "Raw": 150}
    engine.tags["Guard"] = True
    for changes, more in (({}, 0), (start, 3), *PART * PARTS):
        for number in range(stations):
            for name, value in changes.items():
                engine.tags[f"{name}{number}"] = value
        for _ in range(1 + more):
            engine.step(PERIOD_MS)
    return engine


def machine(stations: int, seconds: float) -> float:
    """Return seconds per scan, the results checked."""
    built = parse_program(program(stations))
    compiled, interpreted = (played(each, stations) for each in (built.compile(), built.interpret()))
    assert compiled.memory.snapshot() == interpreted.memory.snapshot()
    for number in range(stations):
        assert compiled.tags[f"Good{number}"] == PARTS, compiled.tags[f"Good{number}"]
        assert compiled.tags[f"Parts{number}.ACC"] == compiled.tags[f"LiftValve{number}.Strokes"] == PARTS
        assert (compiled.tags[f"Fault{number}"], compiled.tags[f"Target{number}"]) == (False, 900)
    scan = compiled._scan
    return per_call(lambda: scan(TIMED_OUT_NS), seconds)


def build_and_scan(count: int) -> None:
    """Build so many rungs, do a scan, and print the memory that took."""
    engine = parse_program(ten_rungs(count // len(RUNGS))).compile()
    engine.step(PERIOD_MS)
    print(highest_mib())


def memory_mib(count: int) -> float:
    """Return the highest memory of a process that builds so many rungs, MiB."""
    words = [sys.executable, __file__, "--build", str(count)]
    return float(subprocess.run(words, capture_output=True, text=True, check=True, encoding="utf-8").stdout)


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    parser.add_argument("--build", type=int, metavar="RUNGS", help="build so many; print the memory in MiB")
    given = parser.parse_args()
    if given.build is not None:
        build_and_scan(given.build)
        return 0
    bars = Bars(count=not given.smoke)
    stations, seconds, count = (2, 0.01, 1_000) if given.smoke else (20, 0.5, 10_000)
    taken = memory_mib(count)
    scan_s = machine(stations, seconds)
    per_rung = scan_s / rungs(stations) * 1e9
    print(f"{rungs(stations):,} rungs of {stations} stations: {scan_s * 1e6:.1f} us a scan, ", end="")
    print(f"{per_rung:.0f} ns a rung ({bars.most('ns a rung', per_rung, RUNG_BAR_NS)})")
    print(f"{count:,} rungs: {taken:.0f} MiB in all ({bars.most('MiB', taken, MEMORY_BAR_MIB)})")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
