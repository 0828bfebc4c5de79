"""A second opinion: another solver checks the certificate of a proof. Nothing of the prover is used here.

`proof.smt2` has the relation of one scan, `proof.json` says what is what (see `ladder.prove.certificate`).
The checker puts scans one behind the other and asks four questions; none may have an answer:

    ranges       a number leaves its interval: at power-up, or in a scan
    invariants   one does not hold after the first scan, or after a scan that follows one after which all held
    base         what never holds does, in one of the first k + 1 scans after power-up
    step         it holds in a scan, and did not in the k scans before, whatever the state before them
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess  # noqa: TID251 - a solver is another program, no helper of ours
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from scanrack.io_images.versions import distribution_version

SECONDS = 60
"""Limit of a question."""

_SYMBOL = re.compile(r"\|[^|]*\||\bt\d+\b")
_DECLARED = re.compile(r"\(declare-const (\|[^|]*\|) (.*)\)$")


class Solver(NamedTuple):
    """A solver: its name with its version, and what it says of a script: unsat, sat, or why it can't tell."""

    name: str
    says: Callable[[str], str]


class Opinion(NamedTuple):
    """What a solver says of a proof.

    Attributes:
        solver: its name with its version.
        confirmed: whether all questions are unsatisfiable.
        refused: whether one is satisfiable: the solvers differ.
        why: the question and the answer, if it is not confirmed.
    """

    solver: str
    confirmed: bool
    refused: bool
    why: str


def solvers() -> list[Solver]:
    """Return the solvers that are there: packages first, then programs."""
    found = {
        name: Solver(f"{name} {distribution_version(its)}", says)
        for name, its, says in _PACKAGES
        if find_spec(name)
    }
    for name, words in _PROGRAMS.items():
        if name not in found and shutil.which(name):
            found[name] = Solver(name, partial(_program, words))
    return list(found.values())


def check(folder: Path, solver: Solver) -> Opinion:
    """Ask a solver about the certificate in a folder.

    Raises:
        OSError, ValueError: it can't be read.
    """
    relation = (folder / "proof.smt2").read_text(encoding="utf-8").splitlines()
    roles = json.loads((folder / "proof.json").read_text(encoding="utf-8"))
    for what, script in questions(relation, roles):
        said = solver.says(script)
        if said != "unsat":
            return Opinion(solver.name, False, said == "sat", f"{what}: {said}")
    return Opinion(solver.name, True, False, "")


def questions(relation: list[str], roles: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the questions of a certificate, each with its name."""
    ranges = [each["term"] for each in roles["ranges"] if each["state"]]
    if ranges:
        for first in (True, False):
            scans = _Scans(relation, roles, first=first)
            if not first:
                scans.add_next()
            yield "ranges", scans.text([_some_not(scans.last(each) for each in ranges)], kept=())
    for part in roles["parts"]:
        kept, bad, k = part["contract"], part["bad"], part["k"]
        found = [each["term"] for each in part["invariants"]]
        for first in (True, False) if found else ():
            scans = _Scans(relation, roles, first=first)
            before = [] if first else [scans.last(each) for each in found]
            if not first:
                scans.add_next()
            broken = _some_not(scans.last(each) for each in found)
            yield f"invariants of {part['says']}", scans.text([*before, broken], kept=(kept,))
        base, step = _Scans(relation, roles, first=True), _Scans(relation, roles, first=False)
        for _ in range(k):
            base.add_next()
            step.add_next()
        some = " ".join(base.each(bad))
        yield f"base of {part['says']}", base.text([f"(or {some} false)"], kept=(kept,))
        helped = [term for each in found for term in step.each(each)]
        *held, last = step.each(bad)
        clean = [f"(not {each})" for each in held]
        yield f"step of {part['says']}", step.text([*helped, *clean, last], kept=(kept,))


class _Scans:
    """Scans one behind the other, as text; each symbol has the number of its scan."""

    def __init__(self, relation: list[str], roles: Mapping[str, Any], *, first: bool) -> None:
        self._relation, self._roles, self.count, self._lines = relation, roles, 0, [relation[0]]
        initial = {name: each["initial"] for name, each in roles["states"].items()} | roles["late"]
        self._add(initial if first else {})

    def add_next(self) -> None:
        """Add a scan: its states are what the one before leaves."""
        self._add({name: self.last(each["next"]) for name, each in self._roles["states"].items()})

    def _add(self, given: Mapping[str, str]) -> None:
        number = self.count
        self.count += 1
        for line in self._relation[1:]:
            declared = _DECLARED.match(line)
            if declared and declared[1] in given:
                name = _numbered(declared[1], number)
                self._lines.append(f"(define-fun {name} () {declared[2]} {given[declared[1]]})")
            else:
                self._lines.append(_numbered(line, number))
        for each in self._roles["ranges"]:
            if each["of"] not in given:
                self._lines.append(f"(assert {_numbered(each['term'], number)})")

    def last(self, term: str) -> str:
        """Return a term in the last scan."""
        return _numbered(term, self.count - 1)

    def each(self, term: str) -> list[str]:
        """Return a term in each scan."""
        return [_numbered(term, number) for number in range(self.count)]

    def text(self, asked: list[str], *, kept: tuple[str, ...]) -> str:
        """Return the script that asks whether some truths can hold, with others in each scan."""
        truths = [*[one for each in kept for one in self.each(each)], *asked]
        return "\n".join([*self._lines, *[f"(assert {each})" for each in truths], "(check-sat)", ""])


def _numbered(text: str, number: int) -> str:
    return _SYMBOL.sub(
        lambda found: f"{found[0].removesuffix('|')}@{number}" + "|" * (found[0][0] == "|"), text
    )


def _some_not(terms: Iterator[str]) -> str:
    return f"(not (and {' '.join(terms)} true))"


# --- solvers


def _z3(text: str) -> str:
    import z3

    solver = z3.Solver()
    solver.set("timeout", SECONDS * 1000)
    solver.from_string(text)
    return str(solver.check())


def _cvc5(text: str) -> str:
    import cvc5

    manager = cvc5.TermManager()
    solver, symbols, said = cvc5.Solver(manager), cvc5.SymbolManager(manager), ""
    solver.setOption("tlimit-per", str(SECONDS * 1000))
    parser = cvc5.InputParser(solver, symbols)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "proof")
    while not (command := parser.nextCommand()).isNull():
        said += str(command.invoke(solver, symbols))
    return said.strip()


def _program(words: list[str], text: str) -> str:
    try:
        done = subprocess.run(
            words, input=text, capture_output=True, encoding="utf-8", timeout=2 * SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return "unknown"
    return next(iter(done.stdout.split("\n")), "").strip() or "no answer"


_PACKAGES: tuple[tuple[str, str, Callable[[str], str]], ...] = (
    ("z3", "z3-solver", _z3),
    ("cvc5", "cvc5", _cvc5),
)
_PROGRAMS = {"z3": ["z3", "-in", f"-T:{SECONDS}"], "cvc5": ["cvc5", "--lang=smt2", f"--tlimit={SECONDS}000"]}
