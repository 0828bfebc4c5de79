"""Structured text does the same on both back ends and in the debugger, and prints as it reads."""

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_lockstep import check_debugged, check_lockstep
from ladder_programs import stimuli
from scanrack.ladder.files import parse_program, program_text
from structured_programs import structured

_SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]


@pytest.mark.slow
@settings(max_examples=amount(16), deadline=None, suppress_health_check=_SLOW)
@given(structured(), stimuli())
def test_both_back_ends_in_lockstep(text, scans):
    check_lockstep(text, scans)


@pytest.mark.slow
@settings(max_examples=amount(6), deadline=None, suppress_health_check=_SLOW)
@given(structured())
def test_structured_text_prints_as_it_reads(text):
    program = parse_program(text)
    printed = program_text(program)
    again = parse_program(printed)
    assert again.routines == program.routines
    assert program_text(again) == printed


@pytest.mark.slow
@settings(max_examples=amount(6), deadline=None, suppress_health_check=_SLOW)
@given(text=structured(), scans=stimuli(), watched=st.booleans())
def test_a_debugged_program_does_what_the_compiled_one_does(text, scans, watched):
    check_debugged(text, scans, watched=watched)


def test_a_subscript_stops_the_scan_before_what_stands_behind_it_is_divided():
    """A difference that the first test has found: the minor fault of the division came first."""
    tags = "PROGRAM p\nTAG D : DINT[2]\nTAG G : DINT[2,2]\nTAG I : DINT := 5\nTAG B : BOOL\nTAG Z : DINT\n"
    statements = (
        "B := D[I] < 7 MOD Z;",
        "Z := D[I] + 7 / Z;",
        "Z := G[I, 7 / Z];",
        "B := D[I].[7 / Z];",
        "G[I, 7 / Z] := 1;",
    )
    for each in statements:
        check_lockstep(f"{tags}ROUTINE Main ST\n{each}\nEND\n", [(1.0, {})])
