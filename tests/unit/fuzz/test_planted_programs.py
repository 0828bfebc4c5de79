"""Each program of the benchmark has its mistake: a scenario breaks it, and not the correct version."""

import pytest
from planted_programs import NAMES, invariant_of, scenario_of, version_of
from scanrack.jobs.fuzz import Scenario


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_mistake_is_there_and_the_correct_version_has_none(name, tmp_path):
    broken = version_of(name, tmp_path / "planted", with_mistake=True)
    correct = version_of(name, tmp_path / "correct", with_mistake=False)
    assert broken.bench.run(Scenario()).broken is None, "the mistake takes an event"
    found = broken.bench.run(scenario_of(name)).broken
    assert found is not None
    assert found.invariant == invariant_of(name, broken)
    assert correct.bench.run(scenario_of(name)).broken is None
