"""Cost of a scan of ladder: per rung, compiled and interpreted, and beside pyrung on the same ten rungs.

    python benchmarks/ladder.py            tables
    python benchmarks/ladder.py --smoke    a short run that only checks

The results are checked: compiled and interpreted end in the same memory, and so
does pyrung, if it is installed (`pip install pyrung`), as far as the two have the
same tags. The ten rungs are what most rungs are: seal-in, timer, counter with
reset, compare, move, add, latch.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from scanrack.ladder import Program
from scanrack.ladder.rungfile import parse_program

PERIOD_MS = 10
TIMED_OUT_NS = 60_000_000_000

BITS = ("Start", "Stop", "Run", "Sensor", "Reset", "High", "Low", "Lamp", "Alarm")
NUMBERS = ("Total", "Level", "Mode")
TAGS = (
    *(f"TAG {name}{{0}} : BOOL" for name in BITS),
    *(f"TAG {name}{{0}} : DINT" for name in NUMBERS),
    "TAG Fill{0} : TIMER",
    "TAG Parts{0} : COUNTER",
)
RUNGS = (
    "[XIC(Start{0}),XIC(Run{0})]XIO(Stop{0})OTE(Run{0});",
    "XIC(Run{0})TON(Fill{0},50,0);",
    "[XIC(Sensor{0})CTU(Parts{0},5,0),XIC(Reset{0})RES(Parts{0})];",
    "GEQ(Parts{0}.ACC,3)OTE(High{0});",
    "LES(Parts{0}.ACC,2)OTE(Low{0});",
    "XIC(Run{0})MOV(Parts{0}.ACC,Total{0});",
    "XIC(High{0})XIO(Low{0})[XIC(Run{0}),XIC(Reset{0})]OTE(Lamp{0});",
    "EQU(Mode{0},2)ADD(Level{0},1,Level{0});",
    "XIC(Start{0})XIC(Fill{0}.DN)OTL(Alarm{0});",
    "XIC(Reset{0})OTU(Alarm{0});",
)

SCRIPT = (
    {"Start": True, "Mode": 2},
    {},
    {"Start": False, "Sensor": True},
    {"Sensor": False},
    {"Sensor": True},
    {"Sensor": False},
    *[{}] * 8,
    {"Sensor": True, "Mode": 0, "Start": True},
    {"Start": False},
)
"""What is set before each scan; the last state is the one that is measured."""

WATCHED = ("Run", "High", "Low", "Lamp", "Alarm", "Total", "Level")


def program(copies: int) -> str:
    """Return the text of a program of ten rungs, so many times."""
    lines = ["PROGRAM benchmark"]
    lines += [line.format(copy) for copy in range(copies) for line in TAGS]
    lines += ["ROUTINE Main", *(rung.format(copy) for copy in range(copies) for rung in RUNGS), "END"]
    return "\n".join(lines)


def per_call(function: Callable[[], object], seconds: float) -> float:
    """Return seconds per call, the best of five rounds."""
    calls, spent = 1, 0.0
    while spent < seconds / 10:
        calls *= 2
        spent = _timed(function, calls)
    return min(_timed(function, calls) for _ in range(5)) / calls


def _timed(function: Callable[[], object], calls: int) -> float:
    begin = time.perf_counter()
    for _ in range(calls):
        function()
    return time.perf_counter() - begin


def played(built: Program, copies: int, *, compiled: bool):
    """Return an engine in the state after the script."""
    engine = built.compile() if compiled else built.interpret()
    for changes in SCRIPT:
        for copy in range(copies):
            for name, value in changes.items():
                engine.tags[f"{name}{copy}"] = value
        engine.step(PERIOD_MS)
    return engine


def ours(copies: int, seconds: float) -> dict[str, float]:
    """Measure a program; return seconds per build and per scan."""
    text = program(copies)
    begin = time.perf_counter()
    built = parse_program(text)
    compiled = built.compile()
    building = time.perf_counter() - begin
    compiled, interpreted = (played(built, copies, compiled=each) for each in (True, False))
    assert compiled.memory.snapshot() == interpreted.memory.snapshot()
    assert compiled.tags["Total0"] == 3, compiled.tags["Total0"]  # three rises of the sensor
    assert compiled.tags["Level0"] == len(SCRIPT) - 2  # Mode is 2 in all scans but the last two
    scan = compiled._scan
    found = {
        "building": building,
        "compiled": per_call(lambda: scan(TIMED_OUT_NS), seconds) - per_call(lambda: None, seconds),
        "step": per_call(lambda: compiled.step(PERIOD_MS), seconds),
        "interpreted": per_call(lambda: interpreted.step(PERIOD_MS), seconds),
    }
    assert compiled.tags["Lamp0"] is True
    return found


def pyrung_engines():
    """Return the same ten rungs in pyrung: (name, step, read) of either engine.

    Raises:
        ImportError: it is not installed.
    """
    import pyrung
    from pyrung.core.compiled_plc import CompiledPLC

    tag = {name: pyrung.Bool(name) for name in BITS}
    tag |= {name: pyrung.Dint(name) for name in NUMBERS}
    fill, parts = pyrung.Timer.clone("Fill"), pyrung.Counter.clone("Parts")
    with pyrung.Program(strict=False) as logic:
        with pyrung.Rung(pyrung.Or(tag["Start"], tag["Run"]), ~tag["Stop"]):
            pyrung.out(tag["Run"])
        with pyrung.Rung(tag["Run"]):
            pyrung.on_delay(fill, 50)
        with pyrung.Rung(pyrung.rise(tag["Sensor"])):
            pyrung.count_up(parts, 5).reset(tag["Reset"])
        with pyrung.Rung(parts.Acc >= 3):
            pyrung.out(tag["High"])
        with pyrung.Rung(parts.Acc < 2):
            pyrung.out(tag["Low"])
        with pyrung.Rung(tag["Run"]):
            pyrung.copy(parts.Acc, tag["Total"])
        with pyrung.Rung(tag["High"], ~tag["Low"], pyrung.Or(tag["Run"], tag["Reset"])):
            pyrung.out(tag["Lamp"])
        with pyrung.Rung(tag["Mode"] == 2):
            pyrung.calc(tag["Level"] + 1, tag["Level"])
        with pyrung.Rung(tag["Start"], fill.Done):
            pyrung.latch(tag["Alarm"])
        with pyrung.Rung(tag["Reset"]):
            pyrung.reset(tag["Alarm"])
    return [
        ("compiled", CompiledPLC(logic, dt=PERIOD_MS / 1000)),
        ("interpreted", pyrung.PLC(logic, dt=PERIOD_MS / 1000)),
    ]


def theirs(seconds: float) -> dict[str, float] | str:
    """Measure pyrung; return seconds per scan by engine, or why not."""
    try:
        engines = pyrung_engines()
    except ImportError as error:
        return f"pyrung is not measured: {error} (pip install pyrung)"
    wanted = played(parse_program(program(1)), 1, compiled=True).tags
    found = {}
    for name, plc in engines:
        for changes in SCRIPT:
            plc.patch(changes)
            plc.step()
        state = plc.current_state.tags
        for watched in WATCHED:
            assert state[watched] == wanted[f"{watched}0"], (name, watched, state[watched])
        found[name] = per_call(plc.step, seconds)
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    seconds = 0.01 if parser.parse_args().smoke else 0.5
    titles = ("to build", "compiled", "per rung", "whole step", "interpreted")
    print(f"{'rungs':>6}", *(f"{title:>12}" for title in titles))
    for copies in (1, 10, 100):
        found = ours(copies, seconds)
        rungs = copies * len(RUNGS)
        print(
            f"{rungs:>6} {found['building']:>10.3f} s {found['compiled'] * 1e6:>9.2f} us "
            f"{found['compiled'] / rungs * 1e9:>9.0f} ns {found['step'] * 1e6:>9.2f} us "
            f"{found['interpreted'] * 1e6:>9.0f} us"
        )
        if copies == 1:
            ten = found
    other = theirs(seconds)
    if isinstance(other, str):
        print(other)
        return
    print("\nten rungs, a whole step: ours compiled, and pyrung beside it")
    for name, spent in other.items():
        print(f"  pyrung {name:<12} {spent * 1e6:>9.2f} us, {spent / ten['step']:>7.1f} times ours")


if __name__ == "__main__":
    main()
