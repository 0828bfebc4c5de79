"""Whatever runs of two programs show, their comparison lists: for each instruction, and each kind of edit."""

from __future__ import annotations

import pytest
from edited_pairs import EDITS, PROCESS, RUNGS, UNPAIRED, Judged, names
from relation_rows import BLOCKS, SLC_HAVOCKED, SLC_OUT, SLC_ROWS
from scanrack.ladder.instructions import NAMES, SPECS
from scanrack.ladder.instructions.slc.rows import SLC_SPECS

pytestmark = pytest.mark.extra("prove")

MOTION = {spec.name for spec in SPECS if "motion" in spec.run.__module__}
PAIRS, SAMPLE = 2000, 160


def test_every_instruction_has_pairs() -> None:
    """Who adds an instruction gives it a text, or says here why no pair has it."""
    assert set(NAMES) - MOTION == {*RUNGS, *BLOCKS, *PROCESS, *UNPAIRED}
    own = {name for name, spec in SLC_SPECS.items() if spec not in SPECS}
    assert own - {*SLC_ROWS, *SLC_HAVOCKED} == SLC_OUT


def judged(seeds: range) -> Judged:
    found = Judged()
    for seed in seeds:
        found.judge(seed)
    return found


@pytest.mark.parametrize(
    ("name", "edit"), [("XIC", "operand"), ("TOD", "condition"), ("DEG", "order"), ("BTDT", "same")]
)
def test_some_pairs_are_not_called_equal_where_a_run_differs(name: str, edit: str) -> None:
    place = names().index(name) + len(names()) * EDITS.index(edit)
    found = judged(range(place, place + 1))
    assert found.false == []
    assert found.count[f"{edit} equal"] == (edit == "same")


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_no_pair_of_a_sample_is_called_equal_where_a_run_differs(part: int) -> None:
    sound_and_useful(range(part, PAIRS, 4 * PAIRS // SAMPLE))


@pytest.mark.long
@pytest.mark.parametrize("part", range(20))
def test_no_pair_is_called_equal_where_a_run_differs(part: int) -> None:
    sound_and_useful(range(part, PAIRS, 20))


def sound_and_useful(seeds: range) -> None:
    """Assert that no pair is called equal wrongly, and that most edits without an effect are called equal."""
    found = judged(seeds)
    count = found.count
    assert found.false == []
    assert count["pairs"] > 0.9 * len(seeds)
    assert sum(count[f"{each} shown by a run"] for each in EDITS[:-1]) > 0.25 * count["pairs"]
    alike = count["same equal"], count["same listed"]
    assert alike[0] > 0.8 * sum(alike)
