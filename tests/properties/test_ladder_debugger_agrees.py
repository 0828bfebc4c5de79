"""A program under the debugger does what it does compiled, watched or not; every scan can be run again."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ladder_lockstep import check_debugged
from ladder_programs import programs, stimuli


@pytest.mark.slow
@given(text=programs(), scans=stimuli(), watched=st.booleans())
def test_a_debugged_program_does_what_the_compiled_one_does(text, scans, watched):
    check_debugged(text, scans, watched=watched)
