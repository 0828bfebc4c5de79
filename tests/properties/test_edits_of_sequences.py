"""Random edits of random programs between two scans, against a restart with the edited program.

The restart has the same inputs from power-up on. If it has done the same up to the edit (images, fields,
waits, steps and locals), the edited run must do the same from there on, or be refused.

Broken on purpose: a match by text alone, locals that are not compared, a loop that begins anew, a wait that
begins again: a test turns red.
"""

import pytest
from amounts import amount
from bench3601 import CONFIGURATION
from edited_sequences import Author, Run, text_of
from scanrack.ladder.python.online.editing import edit_logic
from scanrack.ladder.python.online.field_plan import EditRefusal

SCANS = 200


def played(folder, seed):
    """Return "refused", "another past" or "judged"; assert that a judged edit is right."""
    author = Author(seed)
    program = author.program()
    before, after = (text_of(each, CONFIGURATION) for each in (program, author.edit(program)))
    edited = Run(folder, before, seed)
    at = author.dice.randint(1, 60)
    edited.scan(at)
    fresh = edited.load(after)
    try:
        edit_logic(edited.bench.logic, fresh)
    except EditRefusal:
        return "refused"
    edited.scan(SCANS)
    restarted = Run(folder, after, seed)
    restarted.scan(at + SCANS)
    if edited.scans[:at] != restarted.scans[:at]:
        return "another past"
    assert edited.images == restarted.images
    return "judged"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:coroutine 'Plant:RuntimeWarning")
def test_random_edits_continue_as_a_restart_does_or_are_refused(tmp_path):
    results = [played(tmp_path, seed) for seed in range(amount(25))]
    assert results.count("judged") > len(results) // 3
    assert results.count("refused") < len(results) // 2


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:coroutine 'Plant:RuntimeWarning")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lines_above_that_move_a_program_change_nothing(tmp_path, seed):
    """Each edit moves every line; the run is that without edits."""
    program = Author(seed).program()
    text = text_of(program, CONFIGURATION)
    plain, edited = Run(tmp_path, text, seed), Run(tmp_path, text, seed)
    plain.scan(120)
    refusals = []
    for number in range(6):
        edited.scan(20)
        try:
            edit_logic(edited.bench.logic, edited.load("# moved\n" * (number + 1) + text))
        except EditRefusal as refused:
            refusals.append(str(refused))
    assert edited.images == plain.images
    assert all("finally" in each for each in refusals)
