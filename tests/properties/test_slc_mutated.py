"""Mutated exports of RSLogix 500: refused in our own words, counted, and kept by export and import."""

import random

import pytest
from scanrack.ladder.errors import LadderError
from scanrack.ladder.slc import export_text, import_text

TEXT = """PROJECT "feeder"
SLOT 1 OTHER 3 10 25
LADDER 2 "MAIN"
% the pump seals in %
SOR BST XIC I:2/3 NXB BST XIC B3/17 NXB XIC N7:0/[N7:1] BND BND XIO I:0/1 OTE B3/17 EOR
SOR XIC B3:1/1 TON T4:0 0.01 500 0 EOR SOR XIC T4:0/DN JSR U:3 EOR
SOR XIC S:1/15 COP #N7:0 #N10:4 3 MVM N7:[N7:1] 0FF0h O:1.0 EOR
SOR CPT F8:0 (N7:0 | 2) * -1.5 EOR
SOR LBL Q2:1 ADD #N7:0 1 N7:2 JMP Q2:1 EOR
SOR SQO #N12:0 FFFF O:0.0 R6:0 4 0 SCP N7:0 0 10 0 100 N7:1 EOR
LADDER 3 "FAULTS"
SOR SBR RET EOR
DATA N7:0
% N7:0 % 1 2 3 -4
DATA T4:0 0 500 7
"""
PIECES = [
    "",
    "0",
    "9",
    "/",
    ":",
    "[",
    "]",
    "#",
    ".",
    " ",
    "\n",
    "A",
    "%",
    '"',
    "BST",
    "NXB",
    "BND",
    "EOR",
    "SOR",
    "\x01",
]


def mutated(seed):
    """Return the text with a few characters or words in place of others."""
    dice = random.Random(seed)
    if seed % 2:
        letters = list(TEXT)
        for _ in range(dice.randint(1, 6)):
            letters[dice.randrange(len(letters))] = dice.choice(PIECES)
        return "".join(letters)
    lines = [line.split(" ") for line in TEXT.split("\n")]
    words = TEXT.split()
    for _ in range(dice.randint(1, 4)):
        line = dice.choice(lines)
        line[dice.randrange(len(line))] = dice.choice(words)
    return "\n".join(" ".join(line) for line in lines)


def test_the_text_itself():
    found = import_text(TEXT, "x")
    assert (found.report.rungs, found.report.refused) == (8, [])


@pytest.mark.parametrize("seed", range(60))
def test_a_mutated_export(seed, pytestconfig):
    many = 20 if pytestconfig.getoption("--long", default=False) else 1
    for number in range(seed * many, seed * many + many):
        try:
            found = import_text(mutated(number), "x", file="x.SLC")
        except LadderError:
            continue
        report = found.report
        assert report.imported + len(report.refused) == report.rungs
        if found.program is not None:
            again = import_text(export_text(found.program, found.document), "x")
            assert again.program is not None
            assert [each.rungs for each in again.program.routines] == [
                each.rungs for each in found.program.routines
            ]
