"""`scanrack check`: correct programs have no finding; mistakes planted in them have one."""

import pytest
from check_idioms import IDIOMS
from check_mistakes import MISTAKES
from check_programs import check


@pytest.mark.slow
@pytest.mark.parametrize("name", IDIOMS)
def test_a_correct_program_has_no_findings(name, tmp_path):
    assert check(tmp_path, name, IDIOMS[name]).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda each: f"{each.program}-{each.rule}")
def test_a_mistake_is_found(mistake, tmp_path):
    assert mistake.old in IDIOMS[mistake.program]
    text = IDIOMS[mistake.program].replace(mistake.old, mistake.new, 1)
    first = (mistake.at or mistake.new).strip("\n").partition("\n")[0]
    line = next(number for number, each in enumerate(text.splitlines(), 1) if first in each)
    found = check(tmp_path, mistake.program, text).findings
    assert (mistake.rule, line) in [(each.rule, each.place.line) for each in found], found


def test_all_languages_have_programs():
    kinds = {
        "rungs": "ROUTINE Main\n",
        "text": "ROUTINE Main ST",
        "await": "await ",
        "by hand": "def logic(scan)",
    }
    for each in kinds.values():
        assert sum(each in text for text in IDIOMS.values()) >= 6
    assert sum(name.endswith(".steps") for name in IDIOMS) >= 6
    assert len(IDIOMS) >= 36
    assert len(MISTAKES) >= 50
