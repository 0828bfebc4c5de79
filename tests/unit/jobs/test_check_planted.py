"""`scanrack check`: each planted mistake is found at its line; sound programs have no finding."""

from pathlib import Path

import pytest
from check_planted import OF_THE_RACK, PLANTED, text_of
from check_programs import QUICK, SOUND, check
from scanrack.jobs.check import BY_ID


@pytest.mark.slow
@pytest.mark.parametrize("planted", PLANTED, ids=lambda each: f"{each.program}-{each.rule}")
def test_a_planted_mistake_is_found(planted, tmp_path):
    text = text_of(planted)
    report = check(tmp_path, planted.program, text, controller=planted.controller)
    found = [(each.rule, each.place.line) for each in report.findings]
    first = planted.at.partition("\n")[0]
    lines = [number for number, line in enumerate(text.splitlines(), 1) if first in line]
    if planted.at and not planted.anywhere:
        assert (planted.rule, lines[0]) in found, report.findings
    else:
        assert planted.rule in [each[0] for each in found], report.findings


NAMES = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in SOUND]


@pytest.mark.parametrize("name", NAMES)
def test_a_sound_program_has_no_findings(name, tmp_path):
    assert check(tmp_path, name, SOUND[name]).findings == ()


def test_there_are_planted_mistakes_of_all_rules():
    planted, rules = {each.rule for each in PLANTED}, BY_ID.keys() - OF_THE_RACK.keys()
    assert planted == rules, f"{planted ^ rules}: change a list of tests/support/check_planted.py"
    assert len(PLANTED) >= 90
    assert len(SOUND) >= 30


def test_a_test_plants_each_mistake_of_the_rack():
    tests = [path for path in Path(__file__).parent.glob("test_check*.py") if path != Path(__file__)]
    text = "".join(path.read_text(encoding="utf-8") for path in tests)
    missing = [rule for rule in OF_THE_RACK if f'"{rule}"' not in text]
    assert not missing, f"{missing}: add a row to PLANTED in test_check.py"
