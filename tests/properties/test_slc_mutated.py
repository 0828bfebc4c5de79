"""Mutated exports of RSLogix 500: refused in our own words, counted, and kept by export and import."""

import json
import random
import tomllib
from pathlib import Path

import pytest
from scanrack.jobs.imports.slc_rack import rack_of_slc
from scanrack.ladder import LadderError
from scanrack.rockwell.slc import export_text, import_text
from slc_files import FUNCTION_FILES, elements, export, forces, image, ladder, slot, texts, words

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
SAVED = export(
    ladder(2, "XIC I:1/0 BST TON T33:0 1.0 60 60 NXB MUL N7:1 N7:0 T33:1.PRE BND", "JSR 3"),
    "% TITLE/RUNG DESCRIPTION\nTITLE: Start\nRUNG DESCRIPTION: 50 % of\nthe speed %\n",
    ladder(3, "CTU C5:0 10 3 MOV RTC:0.MIN L41:0", "BSL #B31:0 R6:0 I:1/0 12"),
    image("O:3", "0X0002"),
    words("S", [4, 5414, 0]),
    words("N7", [60, -3, "0XFFF0"]),
    words("F8", ["0.01666667", "1.#INF"]),
    words("L41", [2147483647, "0XFFFFFFFE"], per_line=5),
    elements("T33", [("0XA200", 60, 60), ("0X0200", 60, 0)]),
    elements("C5", [("0X3000", -10, 3)]),
    elements("R6", [("0X8000", 16, 5)], ".LEN   .POS"),
    texts("ST9", "50 % of it", ""),
    FUNCTION_FILES,
    forces("O:03", ("0X0001", "0XFFFF")),
    slots=[slot(1, "1762-IQ16", "16-Input", 1), slot(3, "1762-OB16", "16-Output", 0, 1)],
    names={2: "MAIN", 3: "FEED"},
)
"""As RSLogix 500 saves it."""

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
    "0X",
    "99999",
    "DATA ",
    "FORCE ",
    "1.#",
    "...",
]


def mutated(seed):
    """Return a text with a few characters or words in place of others."""
    dice = random.Random(seed)
    whole = SAVED if seed % 3 else TEXT
    if seed % 2:
        letters = list(whole)
        for _ in range(dice.randint(1, 6)):
            letters[dice.randrange(len(letters))] = dice.choice(PIECES)
        return "".join(letters)
    lines = [line.split(" ") for line in whole.split("\n")]
    listed = whole.split()
    for _ in range(dice.randint(1, 4)):
        line = dice.choice(lines)
        line[dice.randrange(len(line))] = dice.choice(listed)
    return "\n".join(" ".join(line) for line in lines)


def series_of(program):
    return [[rung.series for rung in routine.rungs] for routine in program.routines]


@pytest.mark.parametrize(("text", "rungs", "lost"), [(TEXT, 8, []), (SAVED, 4, ["RTC0"])])
def test_the_text_itself(text, rungs, lost):
    report = import_text(text, "x").report
    assert (report.rungs, report.refused, report.lost) == (rungs, [], lost)


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
        assert json.dumps(report.as_json())
        assert list(report.lines())
        slots = [each["number"] for each in tomllib.loads(rack_of_slc(found, Path("x.SLC")))["slot"]]
        assert len(set(slots)) == len(slots) > 0
        if found.program is not None:
            again = import_text(export_text(found.program, found.document), "x")
            assert again.program is not None
            assert series_of(again.program) == series_of(found.program)
