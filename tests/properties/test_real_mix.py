"""Controllers with the shape of real ones: compiled and interpreted have equal memory after each scan."""

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from ladder_lockstep import differences, outcome
from real_mix import real_controller
from real_rungs import VARIANTS
from scanrack.ladder.state.memory import same
from scanrack.rockwell.l5x import import_l5x

SCANS = 6
RUNGS, TAGS = 100, 120


def imported(folder, seed, variant):
    """Import a generated controller; all of its rungs must be taken."""
    path = folder / "real.L5X"
    path.write_text(real_controller(RUNGS, TAGS, seed=seed, variant=variant), encoding="utf-8")
    found = import_l5x(path)
    assert (found.report.refused, found.report.lost) == ([], [])
    return found.controller


def check(controller, scans):
    """Run both back ends side by side; return the memory before and after."""
    compiled, interpreted = controller.compile(), controller.interpret()
    before = compiled.memory.snapshot()
    for number in range(scans):
        fault, memory, minor = outcome(compiled, 10, {})
        assert (fault, minor) == (None, outcome(interpreted, 10, {})[2]), number
        assert differences(memory, interpreted.memory.snapshot()) == {}, number
    return before, memory


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["mix", "add_ons", "text"])
def test_both_back_ends_agree_in_a_controller_of_the_real_mix(tmp_path, variant):
    before, after = check(imported(tmp_path, 7, variant), SCANS)
    changed = sum(not same(before[path], after[path]) for path in before)
    assert changed > 30, changed


@pytest.mark.slow
@given(seed=st.integers(0, 1 << 32), variant=st.sampled_from(sorted(VARIANTS)))
@settings(max_examples=amount(1))
def test_both_back_ends_agree_in_any_such_controller(tmp_path_factory, seed, variant):
    check(imported(tmp_path_factory.mktemp("real"), seed, variant), SCANS * 2)


def test_the_same_seed_gives_the_same_document():
    assert real_controller(60, 20, seed=3) == real_controller(60, 20, seed=3)
    assert real_controller(60, 20, seed=3) != real_controller(60, 20, seed=4)
