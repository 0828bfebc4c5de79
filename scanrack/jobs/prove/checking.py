"""Has another solver check the certificate of a proof, without using any of the prover's code.

`proof.smt2` has the relation of one scan, and `proof.json` names its parts (see `ladder.prove.certificate`).
The checker writes four kinds of questions about consecutive scans. Each must be unsatisfiable:

    ranges       a number leaves its interval, at power-up or in a scan
    invariants   an invariant fails after the first scan, or after a scan that begins with all invariants true
    base         the claim is broken in one of the first k + 1 scans after power-up
    step         the claim is broken in a scan but not in the k scans before it, from any state
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
"""Time limit for a question."""

_SYMBOL = re.compile(r"\|[^|]*\||\bt\d+\b")
_DECLARED = re.compile(r"\(declare-const (\|[^|]*\|) (.*)\)$")


class Solver(NamedTuple):
    """A solver's name with version, and a function that answers a script with unsat, sat, or a reason."""

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
    installed = {
        name: Solver(f"{name} {distribution_version(package)}", answer)
        for name, package, answer in _PACKAGES
        if find_spec(name)
    }
    for name, words in _PROGRAMS.items():
        if name not in installed and shutil.which(name):
            installed[name] = Solver(name, partial(_program, words))
    return list(installed.values())


def check(folder: Path, solver: Solver) -> Opinion:
    """Have a solver check the certificate in a folder.

    Raises:
        OSError, ValueError: the certificate can't be read.
    """
    relation = (folder / "proof.smt2").read_text(encoding="utf-8").splitlines()
    roles = json.loads((folder / "proof.json").read_text(encoding="utf-8"))
    for question, script in questions(relation, roles):
        if (answer := solver.answer(script)) != "unsat":
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
        base = _Scans(relation, roles, first=True, more=part["k"])
        any_broken = f"(or {' '.join(base.each(part['bad']))} false)"
        yield f"base of {says}", base.text([any_broken], contract)
        step = _Scans(relation, roles, first=False, more=part["k"])
        invariants_true = [term for invariant in invariants for term in step.each(invariant)]
        *earlier_broken, last_broken = step.each(part["bad"])
        unbroken = [f"(not {term})" for term in earlier_broken]
        yield f"step of {says}", step.text([*invariants_true, *unbroken, last_broken], contract)


def _inductive(
    relation: list[str], roles: Mapping[str, Any], terms: list[str], contract: str = ""
) -> Iterator[str]:
    """Yield two scripts that ask if a term can be false after the first scan or after an all-true scan."""
    if not terms:
        return
    first = _Scans(relation, roles, first=True)
    yield first.text([_some_false(first.last(term) for term in terms)], contract)
    scans = _Scans(relation, roles, first=False)
    all_true = [scans.last(term) for term in terms]
    scans.add_next()
    yield scans.text([*all_true, _some_false(scans.last(term) for term in terms)], contract)


class _Scans:
    """Consecutive scans as solver text; each symbol carries the number of its scan.

    Args:
        first: whether the scans begin at power-up; otherwise they begin in any state.
        more: number of scans after the first one.
    """

    def __init__(self, relation: list[str], roles: Mapping[str, Any], *, first: bool, more: int = 0) -> None:
        self._relation, self._roles = relation, roles
        self._count = 0  # number of scans
        self._lines = [relation[0]]  # names the logic; the other lines are repeated for each scan
        initial = {name: state["initial"] for name, state in roles["states"].items()} | roles["late"]
        self._add(initial if first else {})
        for _ in range(more):
            self.add_next()

    def add_next(self) -> None:
        """Add a scan that begins with the states at the end of the previous scan."""
        self._add({name: self.last(state["next"]) for name, state in self._roles["states"].items()})

    def _add(self, values: Mapping[str, str]) -> None:
        """Add a scan in which some variables have the values of other terms, by the variable's name."""
        number = self._count
        self._count += 1
        for line in self._relation[1:]:
            declared = _DECLARED.match(line)
            if declared and declared[1] in values:
                name = _numbered(declared[1], number)
                self._lines.append(f"(define-fun {name} () {declared[2]} {values[declared[1]]})")
            else:
                self._lines.append(_numbered(line, number))
        for bound in self._roles["ranges"]:
            if bound["of"] not in values:
                self._lines.append(f"(assert {_numbered(bound['term'], number)})")

    def last(self, term: str) -> str:
        """Return a term in the last scan."""
        return _numbered(term, self._count - 1)

    def each(self, term: str) -> list[str]:
        """Return a term in each scan."""
        return [_numbered(term, number) for number in range(self._count)]

    def text(self, truths: list[str], contract: str) -> str:
        """Return a script that asks if all `truths` can be true while a contract ("" for none) is true."""
        truths = [*(self.each(contract) if contract else ()), *truths]
        return "\n".join([*self._lines, *[f"(assert {truth})" for truth in truths], "(check-sat)", ""])


def _numbered(text: str, number: int) -> str:
    """Add the number of a scan to each symbol: `t5` becomes `t5@2`, `|Run|` becomes `|Run@2|`."""

    def numbered(match: re.Match[str]) -> str:
        symbol = match[0]
        return f"{symbol[:-1]}@{number}|" if symbol.startswith("|") else f"{symbol}@{number}"

    return _SYMBOL.sub(numbered, text)


def _some_false(terms: Iterator[str]) -> str:
    return f"(not (and {' '.join(terms)} true))"


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
    """Return the first line that a solver program prints for a script; "unknown" if it takes too long."""
    try:
        process = subprocess.run(
            words, input=text, capture_output=True, encoding="utf-8", timeout=2 * SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return "unknown"
    return process.stdout.split("\n")[0].strip() or "no answer"


_PACKAGES: tuple[tuple[str, str, Callable[[str], str]], ...] = (
    ("z3", "z3-solver", _z3),
    ("cvc5", "cvc5", _cvc5),
)
_PROGRAMS = {"z3": ["z3", "-in", f"-T:{SECONDS}"], "cvc5": ["cvc5", "--lang=smt2", f"--tlimit={SECONDS}000"]}
