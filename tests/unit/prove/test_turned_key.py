"""The key is turned to program mode and back: prescan on terms, and proofs that hold through it."""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from random import Random
from typing import Any

import pytest
from amounts import amount
from relation import Relation
from relation_programs import drawn
from relation_rows import BLOCKS, HAVOCKED, ROWS, SLC_ROWS, groups, logix, slc, texts
from scanrack.ladder import LadderFault
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.system.events import KEPT, LEFT_OUT, PROGRAM_MODE, assumed
from scanrack.ladder.run.edit import retain, retained_text, started_again

LATCH = """PROGRAM latch
TAG Start : BOOL
TAG Run : BOOL
TAG Valve : BOOL
ROUTINE Main
[XIC(Start),XIC(Run)]OTE(Run);
XIC(Run)OTL(Valve);
XIO(Run)OTU(Valve);
END
"""

RETENTIVE = """PROGRAM kept
TAG Go : BOOL
TAG Seen : BOOL
TAG First : BOOL
TAG N : DINT
TAG T : TIMER
TAG R : TIMER
ROUTINE Main
XIC(Go)ONS(Seen)ADD(N,1,N);
XIC(Go)TON(T,100,0);
XIC(Go)RTO(R,100,0);
XIC(S:FS)OTE(First);
GRT(N,5)CLR(N);
END
"""


def compared(program: Any, scans: int = 6) -> Counter[str]:
    count = Counter[str]()
    assert Relation(program, turned=True).differences(Random(1), scans, count) == []
    return count


@pytest.mark.slow
@pytest.mark.parametrize("names", list(groups(ROWS)), ids="-".join)
def test_prescan_of_rungs_equals_the_interpreters(names: tuple[str, ...]) -> None:
    assert compared(logix(*texts(ROWS, names)))["values"] > 20


@pytest.mark.slow
@pytest.mark.parametrize("names", list(groups(SLC_ROWS)), ids="-".join)
def test_prescan_of_an_slc_equals_the_interpreters(names: tuple[str, ...]) -> None:
    assert compared(slc(*texts(SLC_ROWS, names)))["values"] > 20


@pytest.mark.slow
def test_prescan_of_blocks_and_of_what_is_not_modeled_equals_the_interpreters() -> None:
    compared(logix(statements=tuple(texts(BLOCKS, tuple(BLOCKS)))))
    compared(logix(*texts(HAVOCKED, tuple(HAVOCKED))))


@pytest.mark.slow
def test_prescan_of_drawn_programs_equals_the_interpreters() -> None:
    """Calls, add-on instructions with their own prescan, computed subscripts that are out of range."""
    for seed in range(amount(12)):
        count = Counter[str]()
        found = Relation(parse_program(drawn(seed)), turned=True).differences(Random(seed), 6, count)
        assert found == [], f"program {seed}"


ADD_ON = """PROGRAM counted
INSTRUCTION Starts
INPUT On : BOOL REQUIRED
LOCAL Times : DINT
OUTPUT Count : DINT
OUTPUT Lit : BOOL
ROUTINE Logic
XIC(On)OTE(Lit);
MOV(Times,Count);
END
ROUTINE Prescan
ADD(Times,1,Times);
END
END INSTRUCTION
TAG A : Starts
TAG Go : BOOL
ROUTINE Main
Starts(A,Go);
END
"""


def test_an_add_on_has_its_prescan() -> None:
    assert Relation(parse_program(ADD_ON), turned=True).differences(Random(1), 20) == []


@pytest.mark.extra("prove")
def test_what_only_prescan_writes_changes_with_the_key() -> None:
    found = parse_program(ADD_ON).prove(never="A.Count > 2")
    assert found.word == "refuted"
    assert sum(each.turned for each in found.scans) == 2
    assert parse_program(ADD_ON).prove(never="A.Count > 2", happens=()).word == "proved"


@pytest.mark.extra("prove")
def test_prescan_drops_a_coil_and_keeps_a_latch() -> None:
    """The next scan finds a valve that is open, and no run: no scan leaves that."""
    claim = "Lost"
    text = LATCH.replace("TAG Valve", "TAG Lost : BOOL\nTAG Valve").replace("ROUTINE Main", FIRST_RUNG)
    found = parse_program(text).prove(never=claim)
    assert found.word == "refuted"
    assert [each.turned for each in found.scans] == [False, True]
    engine = parse_program(text).compile()
    for each in found.scans:
        each.do(engine)
    assert engine.tags["Lost"]
    without = parse_program(text).prove(never=claim, happens=())
    assert without.word == "proved"


FIRST_RUNG = "ROUTINE Main\nXIC(Valve)XIO(Run)OTE(Lost);"


@pytest.mark.extra("prove")
@pytest.mark.parametrize(
    ("claim", "word"),
    [
        ("First AND N > 0", "refuted"),  # a count outlives program mode
        ("First AND T.ACC > 0", "proved"),
        ("First AND R.ACC > 50", "refuted"),
        ("First AND Go AND N <> old(N)", "proved"),  # the storage of a one-shot is set
    ],
)
def test_what_program_mode_keeps(claim: str, word: str) -> None:
    found = parse_program(RETENTIVE).prove(never=claim)
    assert found.word == word, found
    if word == "refuted":
        assert found.scans[-1].turned
        assert "the key was turned to program and back to run" in str(found.steps[-1])


@pytest.mark.extra("prove")
def test_what_a_proof_leaves_out_comes_with_the_option_that_takes_it_in() -> None:
    found = parse_program(RETENTIVE).prove(never="First AND N > 0", happens=())
    assert found.word == "proved"
    said = [each for each in found.assumed if "happens = " in each]
    assert len(said) == len(LEFT_OUT)
    assert said[0] == f'{LEFT_OUT[PROGRAM_MODE]} (happens = ["program mode"])'
    assert said[1].endswith('not with retained tags (happens = ["retained start"])')
    with_it = parse_program(RETENTIVE).prove(never="First AND T.ACC > 0")
    assert not any(LEFT_OUT[PROGRAM_MODE] in each for each in with_it.assumed)


def test_a_proof_that_excludes_no_event_assumes_what_is_retained() -> None:
    assert list(assumed(LEFT_OUT)) == [KEPT]


PASSED = """PROGRAM passed
INSTRUCTION Pass
INPUT On : BOOL REQUIRED
INPUT N : DINT REQUIRED
OUTPUT Lit : BOOL
ROUTINE Logic
XIC(On)OTE(Lit);
END
END INSTRUCTION
TAG A : Pass
TAG Go : BOOL
TAG Word : DINT
TAG Was : BOOL
TAG Number : DINT
TAG Bad : BOOL
TAG Wrong : BOOL
ROUTINE Main
XIC(A.On)XIO(Was)OTE(Bad);
NEQ(A.N,Number)OTE(Wrong);
XIC(Word.3)NOP();
Pass(A,Go,Word);
MOV(Word,Number);
XIC(Go)OTL(Was);
XIO(Go)OTU(Was);
END
"""


@pytest.mark.extra("prove")
@pytest.mark.parametrize("happens", ["program mode", "retained start"])
def test_prescan_reads_what_was_written_before_it(happens: str) -> None:
    """An add-on copies its inputs in prescan: a button that was pressed meanwhile, a bit of a word."""
    assert parse_program(PASSED).prove(never="Bad", happens=[happens]).word == "refuted"
    assert parse_program(PASSED).prove(never="Wrong", happens=[happens]).word != "proved"


def test_an_engine_reads_in_prescan_what_was_written_before_it() -> None:
    engine = parse_program(PASSED).compile()
    engine.step()
    engine.tags["Go"], engine.tags["Word"] = True, 8
    engine.prescan()
    engine.step()
    assert (engine.tags["Bad"], engine.tags["Wrong"]) == (True, True)


@pytest.mark.extra("prove")
@pytest.mark.parametrize(
    ("claim", "word"),
    [
        ("First AND N > 0", "refuted"),
        ("First AND T.ACC > 0", "proved"),
        ("First AND R.ACC > 50", "refuted"),
        ("First AND Go AND N <> old(N)", "proved"),
        ("First AND R.ACC > old(R.ACC)", "proved"),  # its first scan begins to measure the time
    ],
)
def test_what_a_retained_start_keeps(claim: str, word: str) -> None:
    found = parse_program(RETENTIVE).prove(never=claim, happens=["retained start"])
    assert found.word == word, found
    assert KEPT in found.assumed
    if word == "refuted":
        assert (found.scans[-1].again, found.scans[-1].ms) == (True, 0)
        assert "the run ended, and the next run began with its tags" in str(found.steps[-1])


INDEXED = """PROGRAM indexed
TAG At : DINT := 1
TAG T : TIMER[2]
TAG First : BOOL
ROUTINE Main
XIC(S:FS)OTE(First);
MOV(0,At);
MOV(1000,T[At].PRE);
TON(T[At],?,?);
MOV(1,At);
END
"""


@pytest.mark.extra("prove")
def test_no_time_passes_before_the_first_scan_with_retained_tags() -> None:
    """Prescan leaves the timer of another subscript running: program mode counts, a new run begins at 0."""
    claim = "First AND T[0].EN AND old(T[0].EN) AND T[0].ACC > old(T[0].ACC)"
    assert parse_program(INDEXED).prove(never=claim).word == "refuted"
    assert parse_program(INDEXED).prove(never=claim, happens=["retained start"]).word == "proved"
    other = claim.replace(">", "=")
    assert parse_program(INDEXED).prove(never=other, happens=["retained start"]).word == "refuted"


@pytest.mark.parametrize("text", [RETENTIVE, ADD_ON, PASSED, INDEXED, *map(drawn, range(8))])
def test_a_start_on_terms_keeps_what_a_file_of_retained_tags_has(text: str) -> None:
    old = parse_program(text).interpret()
    with suppress(LadderFault):
        for _ in range(3):
            old.step(37)
    by_file = parse_program(text).interpret()
    assert retain(by_file, retained_text(old)) == []
    again, layout = started_again(old, parse_program(text).interpret()), old.lowered.layout
    for leaf in layout.leaves.values():
        if again.memory.has(leaf):
            assert again.memory.values(leaf) == by_file.memory.values(leaf), leaf.path
