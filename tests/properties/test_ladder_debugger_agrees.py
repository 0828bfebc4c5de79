"""A program under the debugger does what it does compiled, watched or not; every scan can be run again."""

from functools import partial

from hypothesis import given
from hypothesis import strategies as st
from ladder_programs import programs, stimuli
from scanrack.ladder import LadderFault
from scanrack.ladder.debug import Debugger
from scanrack.ladder.memory import same
from scanrack.ladder.rungfile import parse_program


def step(run, ms):
    """One scan; a fault is what came of it."""
    try:
        run(ms)
    except LadderFault as fault:
        return str(fault)
    return None


@given(text=programs(), scans=stimuli(), watched=st.booleans())
def test_a_debugged_program_does_what_the_compiled_one_does(text, scans, watched):
    program = parse_program(text)
    engine = program.compile()
    debugger = Debugger(program)
    if watched:
        debugger.break_at("Main", 0)
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
