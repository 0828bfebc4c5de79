"""Programs run on both back ends, and under the debugger, side by side."""

import re
import tempfile
from contextlib import suppress
from functools import partial
from pathlib import Path
from unittest.mock import patch

from scanrack.ladder import BOOL, LadderError, LadderFault
from scanrack.ladder.compiler import source_of
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.state.memory import element_text, same


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


def forceable(debugger):
    """Return the addresses of values and of some bits that can be forced and are written, and their types."""
    found = {}
    layout = debugger._engine.lowered.layout
    source = source_of(debugger._engine.lowered)
    written = set(re.findall(r"^ *(\w+)(?:\.\w+)?(?:\[.*\])? = ", source, re.MULTILINE))
    for leaf in layout.leaves.values():
        spot = layout.spot(leaf)
        if (spot.ident if spot else leaf.ident) not in written:
            continue
        for index in range(min(leaf.size, 3)):
            element = element_text(leaf.path, leaf.dims, index) if leaf.path.count(".") == 0 else leaf.path
            for address in (element, f"{element}.1", f"{element}.{leaf.type.bits - 1}"):
                with suppress(ValueError, LadderError):
                    debugger._single_place(address)
                    found[address] = debugger._single_place(address).type
    return found


def check_observed(text, scans, draw):
    """Run a program under the debugger with random forces and breakpoints, compiled and interpreted.

    Args:
        text: the program.
        scans: what is set before each scan, and how long after the one before it runs.
        draw: draws from a list.
    """
    program = parse_program(text)
    ours, theirs = Debugger(program), Debugger(program)
    theirs.interpreted = True
    rungs = [(each.name, number) for each in program.routines for number in each.numbers]
    forces = sorted(forceable(ours).items())
    for ms, *groups in scans:
        for act, given in _observations(draw, ours, rungs, forces):
            for each in (ours, theirs):
                getattr(each, act)(*given)
        for name, value in (pair for group in groups for pair in group.items()):
            for each in (ours, theirs):
                each.tags[name] = value
        with patch("scanrack.ladder.state.fault_log.MOST_JUMPS", 300):  # a forced loop variable ends no loop
            faults = [step(partial(each.scan, 1), ms) for each in (ours, theirs)]
        assert faults[0] == faults[1]
        values = [each._engine.memory.snapshot() for each in (ours, theirs)]
        assert differences(*values) == {}, saved(text)
        assert ours.stops == theirs.stops, saved(text)
        if draw([True, False]):
            for name in (routine.name for routine in program.routines):
                assert ours.truth(name) == theirs.truth(name), (name, saved(text))
        if faults[0]:
            return


def _observations(draw, debugger, rungs, forces):
    """Draw what is forced, let go and stopped at before a scan."""
    for _ in range(draw([0, 1, 2])):
        address, kind = draw(forces or [("S:V", BOOL)])
        yield "force", (address, draw([0, 1] if kind.is_bool else [0, 1, 2, 7, 100]))
    if debugger.forces and draw([True, False, False]):
        yield "unforce", (draw(sorted(debugger.forces)),)
    if draw([True, False]):
        yield "break_at", draw(rungs)
    if draw([True, False, False, False]):
        yield "clear_breakpoints", ()


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
    again = debugger._past.again(debugger.scans - 1).memory.snapshot()
    assert [path for path in ours if not same(ours[path], again[path])] == []
