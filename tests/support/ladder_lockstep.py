"""Programs run on both back ends, and under the debugger, side by side."""

import tempfile
from functools import partial
from pathlib import Path

from scanrack.ladder import LadderFault
from scanrack.ladder.debug import Debugger
from scanrack.ladder.memory import same
from scanrack.ladder.rungfile import parse_program


def outcome(engine, ms, changes):
    """Do one scan; return what one can see of it."""
    for name, value in changes.items():
        engine.tags[name] = value
    try:
        engine.step(ms)
        fault = None
    except LadderFault as error:
        fault = str(error)
    images = {
        leaf.path: engine.memory.cells[leaf.ident].cell_contents.tolist()
        for leaf in engine.lowered.layout.images
    }
    return fault, engine.memory.snapshot() | images, list(map(str, engine.minor_faults))


def differences(compiled, interpreted):
    """Return the paths of which two snapshots tell different things."""
    return {
        path: (compiled[path], interpreted[path])
        for path in compiled
        if not same(compiled[path], interpreted[path])
    }


def saved(text):
    """Save a program that shows a difference; return where."""
    with tempfile.NamedTemporaryFile("w", suffix=".rung", delete=False, encoding="utf-8") as file:
        file.write(text)
    return Path(file.name)


def check_lockstep(text, scans):
    """Run a program on both back ends; fail at the first scan in which they differ."""
    program = parse_program(text)
    compiled, interpreted = program.compile(), program.interpret()
    for number, (ms, *groups) in enumerate(scans):
        changes = {name: value for group in groups for name, value in group.items()}
        fault, memory, minor = outcome(compiled, ms, changes)
        fault_there, memory_there, minor_there = outcome(interpreted, ms, changes)
        different = differences(memory, memory_there)
        if fault != fault_there or minor != minor_there or (different and not fault):
            where = saved(text)
            raise AssertionError(
                f"scan {number} with {scans[: number + 1]}: {different}, faults {fault} and {fault_there}, "
                f"minor {minor} and {minor_there}; the program is in {where}"
            )
        if fault:
            return


def step(run, ms):
    """One scan; a fault is what came of it."""
    try:
        run(ms)
    except LadderFault as fault:
        return str(fault)
    return None


def check_debugged(text, scans, *, watched):
    """Run a program compiled and under the debugger, and its scans again; fail where they differ."""
    program = parse_program(text)
    engine = program.compile()
    debugger = Debugger(program)
    if watched:
        debugger.break_at(program.routines[0].name, program.routines[0].numbers[0])
    for ms, *groups in scans:
        for name, value in (pair for group in groups for pair in group.items()):
            engine.tags[name] = value
            debugger.tags[name] = value
        faults = step(engine.step, ms), step(partial(debugger.scan, 1), ms)
        assert faults[0] == faults[1]
        if faults[0]:
            return
        ours, theirs = engine.memory.snapshot(), debugger._engine.memory.snapshot()
        assert [path for path in ours if not same(ours[path], theirs[path])] == []
    again = debugger._journal.again(debugger.scans - 1).memory.snapshot()
    assert [path for path in ours if not same(ours[path], again[path])] == []
