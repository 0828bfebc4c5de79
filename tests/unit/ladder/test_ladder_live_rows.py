"""Every row of both instruction sets, drawn live: each line of its box shows the operand that it names.

Broken on purpose: members bound to places 1 and 2 as before, both CONTROLs of FBC bound to the first one,
an SLC drawn with the rows of Logix: red.
"""

import json
import re
from itertools import count
from xml.etree import ElementTree

import pytest
from scanrack.ladder.draw import captions_of, live_rung
from scanrack.ladder.draw.ruler import SYMBOLS
from scanrack.ladder.instructions import SPECS
from scanrack.ladder.instructions.slc import SLC_SPECS
from scanrack.ladder.lowering.dialects import DIALECTS, LOGIX, SLC
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.spec import Use
from scanrack.ladder.model.tree import Address, Instruction, Number, Operand, Rung

TEXT = "{http://www.w3.org/2000/svg}text"
STRUCTURES = {
    **dict.fromkeys((Use.TIMER, Use.COUNTER, Use.SLC_TIMER, Use.SLC_COUNTER), ("PRE", "ACC")),
    **dict.fromkeys((Use.CONTROL, Use.SLC_CONTROL), ("LEN", "POS")),
    Use.ALARM_DIGITAL: ("MinDurationPRE", "MinDurationACC"),
    Use.ALARM_ANALOG: ("HHLimit", "HLimit", "LLimit", "LLLimit"),
}
"""Structures and the members that rungs print after them, in their order [1756-RM003N, 1747-RM001]."""

AFTER = {
    **{(LOGIX, name): 5 for name in ("ALMD", "ALMA")},  # four switches are between
    **{(SLC, name): 2 for name in ("TON", "TOF", "RTO")},  # the time base
    **{(dialect, name): 2 for dialect in (LOGIX, SLC) for name in ("BSL", "BSR")},  # the bit
}
"""How many places after its structure the first member is shown, if not in the next one."""

ROWS = [(LOGIX, spec) for spec in SPECS if spec.in_rungs and spec.operands]
ROWS += [(SLC, spec) for spec in SLC_SPECS.values() if spec.operands]


def operands_of(dialect, spec):
    """Return operands with a value each, and what the page must show for each of them, by place.

    A member of a structure has another value in the controller than in the rung's text.
    """
    numbers, shown = count(100), dict[int, str]()
    operands: list[Operand] = []
    members: dict[int, str] = {}
    is_timer = spec.operands[0] is Use.SLC_TIMER
    for place, use in enumerate(spec.operands):
        if place in members or use in (Use.IGNORED, Use.KEYWORD, Use.CONSTANT, Use.MODE, Use.PASSES):
            text = "0.01" if is_timer and place == 1 else str(next(numbers))
            operands.append(Number(float(text), text))
            shown[place] = members.get(place, text)
            continue
        name = f"Tag{next(numbers)}"
        operands.append(Address(name))
        shown[place] = name
        if use in STRUCTURES:
            first = place + AFTER.get((dialect, spec.name), 1)
            members |= {first + number: f"{name}.{each}" for number, each in enumerate(STRUCTURES[use])}
    return tuple(operands), shown


def drawn(dialect, spec, operands, *, whole=True):
    """Draw an instruction of a dialect on a sheet wide enough for one line per operand."""
    program = Program("one", dialect=dialect)
    rung = Rung((Instruction(spec.name, operands),))
    captions, specs = captions_of(program), DIALECTS[dialect]
    return ElementTree.fromstring(live_rung(rung, "R.0", 400, captions, specs=specs, operands=whole).svg)


def lines_of(root):
    """Return what each line of a box has below its title: caption, text, and the tag whose value is shown."""
    lines: dict[float, dict[str | None, str]] = {}
    for each in root.iter(TEXT):
        kind = "tag" if each.get("data-name") else each.get("class")
        lines.setdefault(round(float(each.get("y", "0"))), {})[kind] = (
            each.get("data-name") or each.text or ""
        )
    rows = [lines[y] for y in sorted(lines)]
    return [
        (row.get("caption", ""), row.get("operand", ""), row.get("tag", ""))
        for row in rows
        if not {"heading", "now"} & row.keys()
    ]


def boxes():
    return [pytest.param(*row, id=f"{row[0]}-{row[1].name}") for row in ROWS if row[1].name not in SYMBOLS]


@pytest.mark.parametrize(("dialect", "spec"), boxes())
def test_a_line_shows_the_value_of_the_operand_that_it_names(dialect, spec):
    operands, shown = operands_of(dialect, spec)
    captions = captions_of(Program("one", dialect=dialect)).get(spec.name, ())
    expected = []
    for place, operand in enumerate(operands):
        caption = captions[place] if place < len(captions) else ""
        if "." in shown[place] and isinstance(operand, Number) and shown[place] != str(operand):
            expected.append((caption, "", shown[place]))  # the member's value in place of the text's number
        else:
            expected.append((caption, str(operand), ""))
        if isinstance(operand, Address):
            expected.append(("", "", shown[place]))
    assert lines_of(drawn(dialect, spec, operands)) == expected


TARGETS = (Use.TARGET, Use.INTEGER_TARGET, Use.TEXT_OR_NUMBER_TARGET)


@pytest.mark.parametrize(("dialect", "spec"), boxes())
def test_what_a_box_says_names_the_members_and_the_destination(dialect, spec):
    operands, shown = operands_of(dialect, spec)
    root = drawn(dialect, spec, operands, whole=False)
    said = [
        text
        for each in root.iter(TEXT)
        if each.get("data-now")
        for _, text in json.loads(each.get("data-now"))
    ]
    targets = [shown[place] for place, use in enumerate(spec.operands) if use in TARGETS]
    for text in said:
        if text.startswith("result "):
            assert text == f"result {{{targets[-1] if spec.name != 'CPT' else targets[0]}}}"
        counted = re.fullmatch(r"\{(\w+)\.(ACC|POS)(?::s\d*)?\} of \{(\w+)\.(PRE|LEN)(?::s\d*)?\}( s)?", text)
        if counted:
            assert counted[1] == counted[3]
            assert f"{counted[1]}.{counted[2]}" in shown.values()
            assert f"{counted[3]}.{counted[4]}" in shown.values()


@pytest.mark.parametrize(("base", "unit"), [("1.0", 1000), ("0.01", 10), ("0.001", 1)])
def test_an_slc_timer_says_its_time_in_seconds(base, unit):
    spec = SLC_SPECS["TON"]
    operands = (Address("T4"), Number(float(base), base), Number(50, "50"), Number(0, "0"))
    (said,) = [
        each.get("data-now")
        for each in drawn(SLC, spec, operands, whole=False).iter(TEXT)
        if each.get("data-now")
    ]
    assert json.loads(said) == [["", f"{{T4.ACC:s{unit}}} of {{T4.PRE:s{unit}}} s"]]
