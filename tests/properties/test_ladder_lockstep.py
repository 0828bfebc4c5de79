"""The compiled program and the interpreter do the same, scan by scan, whatever the program."""

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from ladder_lockstep import check_lockstep
from ladder_programs import programs, stimuli
from scanrack.ladder.files import parse_program, program_text

pytestmark = pytest.mark.slow


@settings(
    max_examples=amount(60),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(programs(), stimuli())
def test_both_back_ends_in_lockstep(text, scans):
    check_lockstep(text, scans)


@settings(
    max_examples=amount(20),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(programs())
def test_a_program_as_text_reads_as_the_same_program(text):
    program = parse_program(text)
    again = parse_program(program_text(program))
    assert [routine.rungs for routine in again.routines] == [routine.rungs for routine in program.routines]
    assert again.declarations == program.declarations
