"""Sequential function charts do the same in both back ends, scan by scan, whatever the chart."""

from contextlib import suppress

import pytest
from amounts import amount
from charts import BothEngines, charts, inputs_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scanrack.ladder import LadderFault
from scanrack.ladder.files import parse_program, program_text


@pytest.mark.slow
@settings(
    max_examples=amount(15),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(charts(), st.lists(st.integers(0, 511), min_size=8, max_size=30))
def test_a_chart_in_both_back_ends_in_lockstep(text, scans):
    """And as text it is the same program."""
    program = parse_program(text)
    assert program_text(parse_program(program_text(program))) == program_text(program)
    both = BothEngines(program)
    with suppress(LadderFault):  # the watchdog ends a circle of true transitions
        for number in scans:
            both.step(inputs_of(number))
