"""Each instruction is computed on terms and equals the interpreter, or leaves open all that it may write."""

from __future__ import annotations

import re
from collections import Counter
from random import Random
from typing import Any

import pytest
from relation import Relation
from relation_rows import (
    BLOCKS,
    HAVOCKED,
    OUT,
    ROWS,
    SLC_HAVOCKED,
    SLC_OUT,
    SLC_ROWS,
    groups,
    logix,
    slc,
    texts,
)
from scanrack.ladder.instructions import NAMES, SPECS
from scanrack.ladder.instructions.slc.rows import SLC_SPECS
from scanrack.ladder.prove.relation.machine import ScanMachine
from scanrack.ladder.prove.relation.symbols import UnmodeledError

pytestmark = pytest.mark.slow  # together they take seconds

MOTION = {spec.name for spec in SPECS if "motion" in spec.run.__module__}


def compared(program: Any, scans: int = 8) -> Relation:
    """Return the relation of a program, after as many scans in which nothing differs."""
    found, count = Relation(program), Counter[str]()
    assert found.differences(Random(1), scans, count) == []
    assert count["scans"] > 1
    return found


def test_every_instruction_is_computed_or_left_open() -> None:
    """Who adds an instruction says here what the prover makes of it."""
    assert set(NAMES) - MOTION == {*ROWS, *BLOCKS, *HAVOCKED, *OUT}
    own = {name for name, spec in SLC_SPECS.items() if spec not in SPECS}
    assert own - {*SLC_ROWS, *SLC_HAVOCKED} == SLC_OUT


@pytest.mark.parametrize("names", list(groups(ROWS)), ids="-".join)
def test_rungs_are_computed(names: tuple[str, ...]) -> None:
    assert compared(logix(*texts(ROWS, names))).machine.cut == []


def test_function_blocks_are_computed() -> None:
    assert compared(logix(statements=tuple(texts(BLOCKS, tuple(BLOCKS))))).machine.cut == []


@pytest.mark.parametrize("names", list(groups(SLC_ROWS)), ids="-".join)
def test_rungs_of_an_slc_are_computed(names: tuple[str, ...]) -> None:
    assert compared(slc(*texts(SLC_ROWS, names))).machine.cut == []


def test_what_is_not_computed_is_left_open() -> None:
    for program, names in (
        (logix(*texts(HAVOCKED, tuple(HAVOCKED))), HAVOCKED),
        (slc(*texts(SLC_HAVOCKED, tuple(SLC_HAVOCKED))), SLC_HAVOCKED),
    ):
        blamed = [site.instruction for site in compared(program).machine.unmodeled.values()]
        open_ = {re.split("[( ]", each)[0] for each in blamed}
        assert set(names) - open_ == set()


PROGRAMS = [*((False, each) for each in groups(ROWS)), *((True, each) for each in groups(SLC_ROWS))]
"""Whether they are of an SLC, and their names."""


@pytest.mark.parametrize(
    ("is_slc", "names"),
    [PROGRAMS[1], *(pytest.param(*each, marks=pytest.mark.slow) for each in PROGRAMS if each != PROGRAMS[1])],
    ids=str,
)
def test_a_row_writes_no_more_than_what_is_left_open(
    is_slc: bool, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """If no row were computed, the known values would still be those of the interpreter."""

    def refuse(*_given: object) -> None:
        raise UnmodeledError("no row is computed")

    monkeypatch.setattr(ScanMachine, "_derived", refuse)
    compared(slc(*texts(SLC_ROWS, names)) if is_slc else logix(*texts(ROWS, names)), 4)
