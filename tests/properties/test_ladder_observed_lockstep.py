"""What a debugged program notes and holds compiled is what the interpreter notes and holds."""

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_lockstep import check_observed
from ladder_programs import programs, stimuli
from structured_programs import structured

pytestmark = pytest.mark.slow

chosen = settings(
    max_examples=amount(6),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@chosen
@given(programs(), stimuli(), st.data())
def test_rungs_under_forces_and_breakpoints(text, scans, data):
    check_observed(text, scans, lambda choices: data.draw(st.sampled_from(choices)))


@chosen
@given(structured(), stimuli(), st.data())
def test_statements_under_forces_and_breakpoints(text, scans, data):
    check_observed(text, scans, lambda choices: data.draw(st.sampled_from(choices)))
