"""Searches as short as the CI profile's find every one of a dozen broken user programs."""

import pytest
from broken_programs import BROKEN_PROGRAMS, found_after


@pytest.mark.slow
@pytest.mark.parametrize("program", BROKEN_PROGRAMS, ids=lambda program: program.name)
def test_a_broken_program_is_found(program):
    assert found_after(program) is not None, program.sentence


def test_there_are_at_least_ten_of_them():
    assert len({program.name for program in BROKEN_PROGRAMS}) >= 10
