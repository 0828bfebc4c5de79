"""The compiled program and the interpreter do the same, scan by scan, whatever the program."""

import tempfile
from pathlib import Path

from amounts import amount
from hypothesis import HealthCheck, given, settings
from ladder_programs import programs, stimuli
from scanrack.ladder import LadderFault
from scanrack.ladder.memory import same
from scanrack.ladder.rungfile import parse_program, program_text


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


@settings(
    max_examples=amount(150),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(programs(), stimuli())
def test_both_back_ends_in_lockstep(text, scans):
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


@settings(
    max_examples=amount(50),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(programs())
def test_a_program_as_text_reads_as_the_same_program(text):
    program = parse_program(text)
    again = parse_program(program_text(program))
    assert [routine.rungs for routine in again.routines] == [routine.rungs for routine in program.routines]
    assert again.declarations == program.declarations
