"""A second opinion: another solver checks the certificate of a proof, without any code of the prover.

`proof.smt2` has the relation of one scan, and `proof.json` names its parts (see `ladder.prove.certificate`).
The checker writes four kinds of questions about consecutive scans. Each must be unsatisfiable:

    ranges       a number leaves its interval, at power-up or in a scan
    invariants   one fails after the first scan, or after a scan that begins with all of them true
    base         what never holds does hold in one of the first k + 1 scans after power-up
    step         it holds in a scan but not in the k scans before, whatever the state before them
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess  # noqa: TID251 - a solver is a program of its own, not one of our helpers
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from scanrack.io_images.versions import distribution_version

SECONDS = 60
"""Time limit of a question."""

_SYMBOL = re.compile(r"\|[^|]*\||\bt\d+\b")
_DECLARED = re.compile(r"\(declare-const (\|[^|]*\|) (.*)\)$")


class Solver(NamedTuple):
    """A solver: its name with version, and a function that answers a script: unsat, sat, or why neither."""

    name: str
    answer: Callable[[str], str]


class Opinion(NamedTuple):
    """A solver's verdict on a proof.

    Attributes:
        solver: its name with its version.
        confirmed: whether all questions are unsatisfiable.
        refused: whether a question is satisfiable, so that the solvers disagree.
        why: the question and its answer, if the proof is not confirmed.
    """

    solver: str
    confirmed: bool
    refused: bool
    why: str


def solvers() -> list[Solver]:
    """Return the installed solvers: Python packages first, then programs."""
    solvers_found = {
        name: Solver(f"{name} {distribution_version(package)}", answer)
        for name, package, answer in _PACKAGES
        if find_spec(name)
    }
    for name, words in _PROGRAMS.items():
        if name not in solvers_found and shutil.which(name):
            solvers_found[name] = Solver(name, partial(_program, words))
    return list(solvers_found.values())


def check(folder: Path, solver: Solver) -> Opinion:
    """Have a solver check the certificate in a folder.

    Raises:
        OSError, ValueError: the certificate can't be read.
    """
    relation = (folder / "proof.smt2").read_text(encoding="utf-8").splitlines()
    roles = json.loads((folder / "proof.json").read_text(encoding="utf-8"))
    for question, script in questions(relation, roles):
        answer = solver.answer(script)
        if answer != "unsat":
            return Opinion(solver.name, False, answer == "sat", f"{question}: {answer}")
    return Opinion(solver.name, True, False, "")


def questions(relation: list[str], roles: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the questions of a certificate, each with its name."""
    ranges = [bound["term"] for bound in roles["ranges"] if bound["state"]]
    for script in _inductive(relation, roles, ranges):
        yield "ranges", script
    for part in roles["parts"]:
        contract, says = part["contract"], part["says"]
        invariants = [invariant["term"] for invariant in part["invariants"]]
        for script in _inductive(relation, roles, invariants, contract):
            yield f"invariants of {says}", script
        base, step = (_Scans(relation, roles, first=first, more=part["k"]) for first in (True, False))
        some = " ".join(base.each(part["bad"]))
        yield f"base of {says}", base.text([f"(or {some} false)"], contract)
        kept = [term for invariant in invariants for term in step.each(invariant)]
        *before, last = step.each(part["bad"])
        unbroken = [f"(not {term})" for term in before]
        yield f"step of {says}", step.text([*kept, *unbroken, last], contract)


def _inductive(
    relation: list[str], roles: Mapping[str, Any], terms: list[str], contract: str = ""
) -> Iterator[str]:
    """Yield the scripts that ask whether the first scan breaks some truths, or a scan after all of them held.

    The intervals of numbers are asserted for each scan, except where a state of the next scan is defined.
    """
    if not terms:
        return
    first = _Scans(relation, roles, first=True)
    yield first.text([_some_not(first.last(term) for term in terms)], contract)
    scans = _Scans(relation, roles, first=False)
    before = [scans.last(term) for term in terms]
    scans.add_next()
    yield scans.text([*before, _some_not(scans.last(term) for term in terms)], contract)


class _Scans:
    """Consecutive scans as solver text; each symbol carries the number of its scan.

    Args:
        first: whether the scans begin at power-up; otherwise they begin in any state.
        more: number of scans after the first one.
    """

    def __init__(self, relation: list[str], roles: Mapping[str, Any], *, first: bool, more: int = 0) -> None:
        self._relation, self._roles, self.count, self._lines = relation, roles, 0, [relation[0]]
        initial = {name: state["initial"] for name, state in roles["states"].items()} | roles["late"]
        self._add(initial if first else {})
        for _ in range(more):
            self.add_next()

    def add_next(self) -> None:
        """Add a scan whose states are what the previous scan leaves."""
        self._add({name: self.last(state["next"]) for name, state in self._roles["states"].items()})

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
        for bound in self._roles["ranges"]:
            if bound["of"] not in given:
                self._lines.append(f"(assert {_numbered(bound['term'], number)})")

    def last(self, term: str) -> str:
        """Return a term in the last scan."""
        return _numbered(term, self.count - 1)

    def each(self, term: str) -> list[str]:
        """Return a term in each scan."""
        return [_numbered(term, number) for number in range(self.count)]

    def text(self, truths: list[str], contract: str) -> str:
        """Return the script that asks whether truths can hold if each scan keeps a contract; "" for none."""
        truths = [*(self.each(contract) if contract else ()), *truths]
        return "\n".join([*self._lines, *[f"(assert {truth})" for truth in truths], "(check-sat)", ""])


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
    solver, symbols, answer = cvc5.Solver(manager), cvc5.SymbolManager(manager), ""
    solver.setOption("tlimit-per", str(SECONDS * 1000))
    parser = cvc5.InputParser(solver, symbols)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "proof")
    while not (command := parser.nextCommand()).isNull():
        answer += str(command.invoke(solver, symbols))
    return answer.strip()


def _program(words: list[str], text: str) -> str:
    try:
        process = subprocess.run(
            words, input=text, capture_output=True, encoding="utf-8", timeout=2 * SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return "unknown"
    return next(iter(process.stdout.split("\n")), "").strip() or "no answer"


_PACKAGES: tuple[tuple[str, str, Callable[[str], str]], ...] = (
    ("z3", "z3-solver", _z3),
    ("cvc5", "cvc5", _cvc5),
)
_PROGRAMS = {"z3": ["z3", "-in", f"-T:{SECONDS}"], "cvc5": ["cvc5", "--lang=smt2", f"--tlimit={SECONDS}000"]}
