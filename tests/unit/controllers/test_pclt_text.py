"""The text format of stored programs: what is refused, and where it says the mistake is."""

from __future__ import annotations

import pytest
from scanrack.io_images.pcl601.program import CAPACITY_BYTES, INSTRUCTIONS, ProgramError, parse_program

MISTAKES = [
    (
        "ACEL 500\nEND",
        "line 1, column 1: 'ACEL' begins no instruction and no directive; like it: ACCEL",
    ),
    ("DIR CW\nMOVE\nEND", "line 2, column 5: the line ends too early; allowed here: a number"),
    ("MOVE 0\nEND", "line 1, column 6: 0 is out of range: a number of steps is 1 to 8388607"),
    ("MOVE " + "9" * 5000 + "\nEND", "line 1, column 6: '9"),
    ("ENCRATIO 1.5\nEND", "line 1, column 10: '1.5' is unexpected; allowed here: a number"),
    ("IF INPUT 7 = 0\nEND", "line 1, column 10: 7 is out of range: an input is 1 to 6"),
    ("IF INPUT 3 0\nEND", "line 1, column 12: '0' is unexpected; allowed here: ="),
    (
        "IF INPUTS 1101\nEND",
        "11: '1101' is unexpected; allowed here: six digits 0 or 1, input 1 first",
    ),
    ("DIR LEFT\nEND", "line 1, column 5: 'LEFT' is unexpected; allowed here: CW or CCW"),
    ("LOOP 3 A\nEND", "line 1, column 6: '3' is unexpected; allowed here: OUTER, INNER"),
    ("END END", "line 1, column 5: 'END' is unexpected; allowed here: the end of the line"),
    ('TEXT "@1G\nEND', "line 1, column 6: '\"@1G' is unexpected; allowed here: text in quotes"),
    (f'TEXT "{"x" * 21}"\nEND', "line 1, column 6: 21 characters are too many: text is at most 20"),
    ('TEXT "é"\nEND', "line 1, column 6: 'é' can't be sent: text must be printable ASCII"),
    ('TEXT "a\\t"\nEND', "line 1, column 6: \\t is unknown"),
    (".axis 100\nEND", "line 1, column 7: 100 is out of range: an axis is 0 to 99"),
    (".axis 1\n.axis 1\nEND", "line 2, column 1: .axis is given twice"),
    ("GOTO X\nEND", "line 1: label X is unknown: the program has none"),
    ("LABEL A\nGOTO B\nEND", "line 2: label B is unknown: known are A"),
    ("LABEL A\n\nLABEL a\nEND", "line 3: label A is given twice"),
    ("LOOP INNER 3 A\nLABEL A\nEND", "line 1: label A must be above the loop"),
    ("LABEL A\nLOOP INNER 2 A\nLOOP INNER 3 A\nEND", "line 3: an inner loop can't be inside an inner loop"),
    ("LABEL A\nLOOP OUTER 2 A\nLOOP OUTER 3 A\nEND", "line 3: an outer loop can't be inside an outer loop"),
    ("LABEL A\nLOOP OUTER 2 A\nLOOP INNER 3 A\nEND", "line 3: an outer loop can't be inside an inner loop"),
    ("END\nMOVE 5", "line 2: END is missing: it must be the last instruction"),
    ("", "END is missing"),
]


@pytest.mark.parametrize(
    ("text", "said"), MISTAKES, ids=[said.split(":")[-1].strip()[:40] for _, said in MISTAKES]
)
def test_a_mistake_is_told_with_its_place(text: str, said: str) -> None:
    with pytest.raises(ProgramError) as caught:
        parse_program(text)
    assert said in str(caught.value)


def test_several_inner_loops_fit_into_an_outer_one() -> None:
    inner = "LABEL {0}\nWAIT 1\nLOOP INNER 2 {0}\n"
    program = parse_program("LABEL A\n" + inner.format("B") + inner.format("C") + "LOOP OUTER 2 A\nEND")
    assert program.size == 2 + 2 * (2 + 4 + 7) + 7 + 2


def test_memory_of_2046_bytes_is_full_to_the_last() -> None:
    moves = "MOVE 1\n" * ((CAPACITY_BYTES - 6) // 6)
    assert parse_program(moves + "WAIT 1\nEND").size == CAPACITY_BYTES
    with pytest.raises(ProgramError, match="2048 bytes: program memory holds 2046"):
        parse_program(moves + "WAIT 1\nFINISH\nEND")


def test_every_instruction_but_text_takes_2_to_7_bytes() -> None:
    """Section 3 of the manual, with the size of a text as the exception that it can't be otherwise."""
    assert {row.size for row in INSTRUCTIONS} <= set(range(2, 8))
    assert parse_program(f'TEXT "{"x" * 20}"\nEND').size == 2 + 20 + 2


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("ACCEL", 100, 9_999_999),
        ("BASE", 1, 5000),
        ("MAX", 1, 50_000),
        ("WAIT", 1, 65_535),
        ("ENCDELAY", 0, 65_535),
        ("ENCRATIO", 1, 255),
        ("ENCRETRIES", 0, 255),
        ("ENCWINDOW", 0, 255),
        ("OOTFCOUNT", 0, 255),
        ("APOSLO", 0, 65_535),
        ("ASPEEDLO", 1, 50_000),
    ],
)
def test_each_number_has_the_range_of_its_register(name: str, low: int, high: int) -> None:
    for value in (low, high):
        assert parse_program(f"{name} {value}\nEND\n").steps[0].values == (value,)
    for value in (low - 1, high + 1):
        with pytest.raises(ProgramError, match=f" is {low} to {high}$"):
            parse_program(f"{name} {value}\nEND\n")


@pytest.mark.parametrize("text", ["DIR CW", "CURRENT OFF", "THUMB ON", "ENC ON", "IOTF OFF", "REPEAT"])
def test_one_of_two_words_takes_no_byte_beside_the_instruction_s_two(text: str) -> None:
    assert parse_program(f"{text}\nEND\n").steps[0].instruction.size == 2
