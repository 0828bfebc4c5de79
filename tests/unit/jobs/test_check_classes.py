"""`scanrack check`: classes of mistakes, in each language where they apply; the sound programs have none."""

from __future__ import annotations

from pathlib import Path

import pytest
from check_classes import ALWAYS_ON, CASES_BY_RULE, CLASSES, Case
from check_programs import RACK, check
from scanrack.jobs.check import CheckReport, check_rack, load_any


def checked(folder: Path, name: str, text: str) -> CheckReport:
    """Check a program in the rack; an export alone."""
    if not name.endswith((".L5X", ".SLC")):
        return check(folder, name, text)
    (folder / name).write_text(text, encoding="utf-8")
    job, alone = load_any(str(folder / name))
    return check_rack(job, alone=alone)


@pytest.mark.parametrize("case", CASES_BY_RULE, ids=lambda each: f"{each.rule}-{each.name}")
def test_a_mistake_of_a_class_is_found_and_a_sound_program_has_none(case: Case, tmp_path: Path) -> None:
    found = [(each.rule, each.place.line) for each in checked(tmp_path, case.name, case.text).findings]
    line = next(number for number, each in enumerate(case.text.splitlines(), 1) if case.at in each)
    assert (case.rule, line) in found
    assert checked(tmp_path, case.name, case.sound).findings == ()


def test_each_class_has_three_programs() -> None:
    assert all(len(rows) >= 3 for rows in CLASSES.values())


def switch(name: str, *, closed: bool) -> str:
    """Return a rack whose switch is a normally closed or a normally open contact."""
    rows = [row for row in RACK.splitlines() if f'input = "{name}"' in row]
    made = rows[0].replace(" },", ", normally_closed = true },")
    return RACK.replace(rows[0], made) if closed else RACK


@pytest.mark.parametrize(
    ("name", "closed", "active", "wrong"),
    [
        ("home", True, "", True),
        ("home", True, ", active_high=0x3F & ~InputBit.HOME", False),
        ("home", False, "", False),
        ("home", False, ", active_high=0x3F & ~InputBit.HOME", True),
        ("ccw_limit", True, "", True),
        ("ccw_limit", True, ", active_high=0x3F & ~InputBit.CCW_LIMIT", False),
        ("cw_limit", False, ", active_high=0x3F & ~InputBit.CW_LIMIT", True),
    ],
)
def test_a_contact_and_the_level_of_its_input(
    name: str, closed: bool, active: str, wrong: bool, tmp_path: Path
) -> None:
    rack = switch(name, closed=closed)
    report = check(tmp_path, "line.py", ALWAYS_ON.replace("ACTIVE", active), rack=rack)
    found = [each for each in report.findings if each.rule == "wrong-level"]
    assert bool(found) is wrong
    if wrong:
        line = next(number for number, row in enumerate(rack.splitlines(), 1) if f'"{name}"' in row)
        assert [each.place.line for each in found] == [line]
        kind, level = ("normally closed", "high") if closed else ("normally open", "low")
        expected = f"{name} is {kind}, but it is configured as active {level}: it is active at rest"
        assert expected in found[0].text


@pytest.mark.parametrize(
    ("timeline", "active", "wrong"),
    [
        ("{ at_s = 8.0, input = 'estop', for_ms = 500 }", "", False),
        ("{ at_s = 8.0, input = 'estop', for_ms = 500 }", ", active_high=0x3F & ~InputBit.ESTOP", True),
        (
            "{ at_s = 0, input = 'estop' }, { at_s = 8.0, input = 'estop', for_ms = 500, energized = false }",
            "",
            True,
        ),
        (
            "{ at_s = 0, input = 'estop' }, { at_s = 8.0, input = 'estop', for_ms = 500, energized = false }",
            ", active_high=0x3F & ~InputBit.ESTOP",
            False,
        ),
    ],
)
def test_an_emergency_stop_and_the_level_of_its_input(
    timeline: str, active: str, wrong: bool, tmp_path: Path
) -> None:
    rack = RACK.replace("[slot.machine]\n", f"[slot.machine]\ntimeline = [{timeline}]\n", 1)
    text = ALWAYS_ON.replace("InputBit.HOME", "InputBit.HOME | InputBit.ESTOP").replace("ACTIVE", active)
    report = check(tmp_path, "line.py", text, rack=rack)
    assert ("wrong-level" in [each.rule for each in report.findings]) is wrong


def test_a_home_switch_beyond_a_limit(tmp_path: Path) -> None:
    """The search for home ends at the limit before; a home switch at its edge is reached."""
    text = ALWAYS_ON.replace("ACTIVE", "")
    for first, wrong in ((-5500, True), (-4000, True), (-4100, False)):
        last = -3900 if not wrong else first
        rack = RACK.replace("first = -1500, last = -1300", f"first = {first}, last = {last}")
        found = check(tmp_path, "line.py", text, rack=rack).findings
        said = [each.text for each in found if each.rule == "search-without-switch"]
        expected = "slot 1: home lies where ccw_limit is operated: the limit ends the search first"
        assert said == [expected] * wrong
