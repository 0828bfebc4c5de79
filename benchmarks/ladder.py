"""Cost of a scan of ladder: per rung, compiled and interpreted, and beside pyrung on the same ten rungs.

    python benchmarks/ladder.py            tables
    python benchmarks/ladder.py --smoke    a short run that only checks

Then add-on instructions: building 400 calls of a block of 41 rungs (the ten rungs four times, and one more),
and what a call costs beside the same rungs inline, for instances that are tags and for elements of an array.

The results are checked: compiled and interpreted end in the same memory, and so
does pyrung, if it is installed (`pip install pyrung`), as far as the two have the
same tags. The ten rungs are what most rungs are: seal-in, timer, counter with
reset, compare, move, add, latch.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

from bars import Bars
from scanrack.ladder import LadderLogic
from scanrack.ladder.files.rungfile import parse_program

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

SCRIPT: tuple[dict[str, bool | int], ...] = (
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


def played(built: LadderLogic, copies: int, *, compiled: bool):
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


BLOCKS = 4
"""The ten rungs in an add-on instruction, so many times."""

CALLS = 400
BUILD_LIMIT_S = 0.5
CALL_LIMIT = 2.0
MEASURED_CALLS = 20


def with_calls(calls: int, *, array: bool) -> str:
    """Return the text of a program that calls a block of 41 rungs, its instances tags or one array."""
    own = [line.format(copy).replace("TAG", "LOCAL", 1) for copy in range(BLOCKS) for line in TAGS]
    rungs = [rung.format(copy) for copy in range(BLOCKS) for rung in RUNGS]
    instances = [f"TAG Block : Forty[{calls}]"] if array else [f"TAG Block{n} : Forty" for n in range(calls)]
    names = [f"Block[{n}]" if array else f"Block{n}" for n in range(calls)]
    return "\n".join(
        [
            "PROGRAM calls",
            "INSTRUCTION Forty",
            "INPUT Go : BOOL REQUIRED",
            "INPUT Preset : DINT REQUIRED",
            "OUTPUT Done : BOOL REQUIRED",
            *own,
            "ROUTINE Logic",
            *rungs,
            "XIC(Go)GRT(Preset,3)OTE(Done);",
            "END",
            "END INSTRUCTION",
            *instances,
            *(f"TAG Go{n} : BOOL\nTAG Done{n} : BOOL" for n in range(calls)),
            "ROUTINE Main",
            *(f"Forty({name},Go{n},5,Done{n});" for n, name in enumerate(names)),
            "END",
        ]
    )


def without_calls(calls: int) -> str:
    """Return the text of a program with the rungs of as many calls."""
    lines = ["PROGRAM inline"]
    lines += [line.format(copy) for copy in range(calls * BLOCKS) for line in TAGS]
    lines += [f"TAG Go{n} : BOOL\nTAG Done{n} : BOOL\nTAG Preset{n} : DINT := 5" for n in range(calls)]
    rungs = [rung.format(copy) for copy in range(calls * BLOCKS) for rung in RUNGS]
    rungs += [f"XIC(Go{n})GRT(Preset{n},3)OTE(Done{n});" for n in range(calls)]
    return "\n".join([*lines, "ROUTINE Main", *rungs, "END"])


def played_calls(text: str, form: str):
    """Return an engine in the state after the script; `form` is the name of a tag of a call and a copy."""
    engine = parse_program(text).compile()
    for changes in SCRIPT:
        for call in range(MEASURED_CALLS):
            engine.tags[f"Go{call}"] = True
            for copy in range(BLOCKS):
                for name, value in changes.items():
                    engine.tags[form.format(call=call, name=name, copy=copy, flat=call * BLOCKS + copy)] = (
                        value
                    )
        engine.step(PERIOD_MS)
    return engine


def add_ons(seconds: float) -> tuple[float, float, dict[str, float]]:
    """Measure add-on instructions.

    Returns:
        Seconds of processor time to build `CALLS` calls, seconds of the rungs of a call inline, and what a
        call costs as a multiple of that, by the kind of instance.
    """
    begin = time.process_time()
    parse_program(with_calls(CALLS, array=False)).compile()
    building = time.process_time() - begin
    inline = played_calls(without_calls(MEASURED_CALLS), "{name}{flat}")
    engines = {
        "tags": played_calls(with_calls(MEASURED_CALLS, array=False), "Block{call}.{name}{copy}"),
        "array": played_calls(with_calls(MEASURED_CALLS, array=True), "Block[{call}].{name}{copy}"),
    }
    for name in ("Total{copy}", "Level{copy}", "Fill{copy}.ACC"):
        wanted = inline.tags[name.format(copy=0)]
        assert engines["tags"].tags[f"Block0.{name.format(copy=0)}"] == wanted
        assert engines["array"].tags[f"Block[0].{name.format(copy=0)}"] == wanted

    def cost(engine) -> float:
        return per_call(lambda: engine._scan(TIMED_OUT_NS), seconds) / MEASURED_CALLS

    beside = cost(inline)
    return building, beside, {kind: cost(engine) / beside for kind, engine in engines.items()}


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


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    smoke = parser.parse_args().smoke
    seconds, bars = 0.01 if smoke else 0.5, Bars(count=not smoke)
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
    building, beside, ratios = add_ons(seconds)
    print(f"\nadd-ons: {CALLS} calls of a block of {BLOCKS * len(RUNGS) + 1} rungs", end=" ")
    print(
        f"built in {building:.2f} s of processor time ({bars.most('s to build', building, BUILD_LIMIT_S)} s)"
    )
    for kind, ratio in ratios.items():
        print(f"  a call, instances {kind:<6} {ratio:>5.2f} times its {beside * 1e6:.2f} us inline", end=" ")
        print(f"({bars.most(kind, ratio, CALL_LIMIT)})")
    other = theirs(seconds)
    if isinstance(other, str):
        print(other)
        return bars.status()
    print("\nten rungs, a whole step: ours compiled, and pyrung beside it")
    for name, spent in other.items():
        print(f"  pyrung {name:<12} {spent * 1e6:>9.2f} us, {spent / ten['step']:>7.1f} times ours")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
