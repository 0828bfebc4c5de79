"""A row that is refused midway leaves no trace: what the relation still knows is what the interpreter has.

Every second row of a program raises at its first, second or third write, or behind its last. A defect that
lets a refused row leave something behind, or frees less than it may have written, has values that differ.
"""

from __future__ import annotations

from collections import Counter
from functools import partial
from random import Random
from typing import Any

import pytest
from relation import Relation
from relation_programs import SHORT, nested
from relation_rows import BLOCKS, ROWS, SLC_ROWS, groups, logix, slc, texts
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.algebra.terms import TRUE, and_, ite
from scanrack.ladder.prove.relation.machine import ScanMachine
from scanrack.ladder.prove.relation.noting import NotingMachine
from scanrack.ladder.prove.relation.symbols import UnmodeledError

BEHIND = 0
"""In place of a number of a write: behind the last one."""


class Planted:
    """Rows that raise at a write.

    Args:
        at: number of the write, from 1, or `BEHIND`.
        odd: which half of the instructions raises, by their numbers in the program.
    """

    def __init__(self, at: int, odd: int, monkeypatch: pytest.MonkeyPatch) -> None:
        self.at, self.odd, self.met = at, odd, Counter[str]()
        self._left: list[list[int]] = [[0]]
        row, poke = ScanMachine._row, ScanMachine.poke

        def planted_row(machine: Any, step: Any, power: Any) -> Any:
            is_planted = step.site % 2 == self.odd
            self._left.append([self.at if is_planted else 0])
            try:
                after = row(machine, step, power)
            finally:
                left = self._left.pop()[0]
            if is_planted and (self.at == BEHIND or left < self.at):
                self.met[step.name] += 1
                raise UnmodeledError("behind the last write")
            return after

        def planted_poke(machine: Any, *given: Any) -> None:
            left = self._left[-1]
            if left[0]:
                left[0] -= 1
                if not left[0]:
                    self.met[machine.lowered.sites[machine.site].instruction.partition("(")[0]] += 1
                    raise UnmodeledError("at a write")
            poke(machine, *given)

        monkeypatch.setattr(ScanMachine, "_row", planted_row)
        monkeypatch.setattr(ScanMachine, "poke", planted_poke)


def programs() -> dict[str, list[Any]]:
    """Return what makes programs of the rows of all families, one for each instruction, by group."""
    found = {names: [partial(logix, *ROWS[each]) for each in names] for names in groups(ROWS)}
    found |= {
        ("slc", *names): [partial(slc, *SLC_ROWS[each]) for each in names] for names in groups(SLC_ROWS)
    }
    found["blocks",] = [partial(logix, statements=tuple(texts(BLOCKS, tuple(BLOCKS))))]
    return {"-".join(names): programs for names, programs in found.items()}


PROGRAMS = programs()


@pytest.mark.slow
@pytest.mark.parametrize("group", PROGRAMS)
def test_a_row_that_raises_leaves_no_trace(group: str, monkeypatch: pytest.MonkeyPatch) -> None:
    count = Counter[str]()
    for make in PROGRAMS[group]:
        program = make()
        for at in (1, 2, 3, BEHIND):
            for odd in (0, 1):
                with monkeypatch.context() as patch:
                    planted = Planted(at, odd, patch)
                    found = Relation(program)
                if planted.met:
                    assert found.differences(Random(at), 4, count) == [], (program.name, at, odd)
    assert count["values"] > 40


@pytest.mark.slow
def test_every_row_raises_somewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    met = Counter[str]()
    for make in (each for group in PROGRAMS.values() for each in group):
        for odd in (0, 1):
            with monkeypatch.context() as patch:
                planted = Planted(BEHIND, odd, patch)
                Relation(make())
            met += planted.met
    assert {*ROWS, *BLOCKS, *SLC_ROWS} - met.keys() == set()


def test_a_stored_term_is_not_the_one_that_holds_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first false proof: what a place holds where a refused copy is not reached."""
    assert Relation(parse_program(SHORT)).differences(Random(1), 20) == []

    def simplified(machine: Any, key: Any, where: Any, t: Any) -> None:
        here = machine._reached(machine._kept[key])
        machine.log.put(machine._kept, key, ite(and_(machine.active, where), t, here))

    monkeypatch.setattr(ScanMachine, "_assign", simplified)
    assert Relation(parse_program(SHORT)).differences(Random(1), 20)


def test_a_refused_row_is_not_followed_wherever_it_acts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second false proof: an add-on instruction that acts without power."""
    assert Relation(parse_program(nested(12))).differences(Random(1), 20) == []
    monkeypatch.setattr(ScanMachine, "_acting", lambda _machine, _step, power: power)
    assert Relation(parse_program(nested(12))).differences(Random(1), 20)


CALL = """PROGRAM calls
ALLOW repeated coils
TAG A : BOOL
TAG B : BOOL
TAG X : DINT
TAG Y : DINT
ROUTINE Main
XIC(A)JSR(Sub,1,X,Y);
XIC(Y.0)OTE(B);
END
ROUTINE Sub
SBR(X)ADD(X,1,X);
XIC(B)RET(X);
DIV(X,Y,X);
RET(3);
END
"""


def test_all_that_a_refused_call_did_is_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    row = ScanMachine._row

    def refused(machine: Any, step: Any, power: Any) -> Any:
        after = row(machine, step, power)
        if step.name == "JSR":
            raise UnmodeledError("behind its last write")
        return after

    monkeypatch.setattr(ScanMachine, "_row", refused)
    machine = NotingMachine(parse_program(CALL).build())
    machine.scan_terms()
    assert {machine.lowered.sites[site].routine for site in machine.passages} == {"Main"}
    assert machine.faults == []
    assert [name for _, name, _ in machine.cut] == ["JSR"]
    noted: Any = machine.fault_log
    assert not any(kind == "zero divisor" for _, kind in noted.minor)
    assert machine.state["X", 0] is machine.vars["X", 0]  # it is as the scan found it
    assert (machine.active, machine.deep) == (TRUE, machine.vars["A", 0])
