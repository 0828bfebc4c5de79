"""The certificate of a proof: the relation of one scan as SMT-LIB text, and the induction.

`proof.smt2` declares the values before a scan, and defines terms of these values. `proof.json` lists the
roles of the terms: the next value and the initial value of each state, the assumption of each scan, the
condition that is never true, and the invariants. With the two files, a checker does not need the prover's
code. The checker writes consecutive scans as SMT-LIB and runs another solver.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .algebra.meaning import INT
from .algebra.terms import T, variables
from .solving.smtlib import Script, Text
from .solving.translation import fit, interval_conditions, literal, sort_of, translate, width

if TYPE_CHECKING:
    from .solving.invariants import Invariant
    from .system import System

FORMAT = "scanrack proof 1"


@dataclass(frozen=True, slots=True)
class Certificate:
    """A proof by induction that `bad` is never true.

    Attributes:
        says: the proved claim, in words.
        next: the next value of each state that decides `bad`, by name.
        initial: initial values of states, held variables and late variables.
        held: names of variables that keep their initial value.
        late: names of free variables that keep their initial value in the first scan.
        contract: the condition assumed in each scan.
        bad: the condition that is never true.
        k: number of scans in the induction.
        invariants: conditions that are true in the state after each scan.
    """

    says: str
    next: Mapping[str, T]
    initial: Mapping[str, Any]
    held: frozenset[str]
    late: frozenset[str]
    contract: T
    bad: T
    k: int
    invariants: tuple[Invariant, ...] = ()

    @classmethod
    def of(
        cls, system: System, says: str, bad: T, k: int, used_invariants: Sequence[Invariant] = ()
    ) -> Certificate:
        """Return the certificate of a proof about a system, with the system's current contract."""
        cone = system.cone([bad, *[invariant.term for invariant in used_invariants]])
        states = {name: system.next[name] for name in cone if name in system.next}
        initial = {name: system.initial[name] for name in cone if name in system.initial}
        held, late = frozenset(system.held & cone.keys()), frozenset(system.late & cone.keys())
        return cls(says, states, initial, held, late, system.contract, bad, k, tuple(used_invariants))


def written(certificates: Sequence[Certificate]) -> tuple[str, dict[str, Any]]:
    """Return the text of `proof.smt2` and the contents of `proof.json` for proofs about one program."""
    writer = _ScriptWriter()
    parts = [writer.part(certificate) for certificate in certificates]
    header = {"format": FORMAT, "states": writer.states, "late": writer.late, "ranges": writer.ranges}
    return "\n".join([*writer.script.lines, ""]), {**header, "parts": parts}


class _ScriptWriter:
    """Writes the relation once, for all proofs about a program."""

    def __init__(self) -> None:
        self.script = Script()
        self.states: dict[str, dict[str, str]] = {}  # next and initial value of each state, by declared name
        self.late: dict[str, str] = {}  # initial values of late variables, by declared name
        self.ranges: list[dict[str, Any]] = []  # conditions that keep variables in their intervals
        self._memo: dict[int, Any] = {}  # translated terms by id
        self._declared: dict[str, Text] = {}  # declared variables by name

    def part(self, certificate: Certificate) -> dict[str, Any]:
        """Write the terms of a proof; return their roles."""
        self._memo = {}  # another part may have other held values
        contract, bad = (
            self._term(certificate, certificate.contract),
            self._term(certificate, certificate.bad),
        )
        invariants = [
            {"term": self._term(certificate, invariant.term), "text": invariant.text}
            for invariant in certificate.invariants
        ]
        roots = [
            certificate.contract,
            certificate.bad,
            *[invariant.term for invariant in certificate.invariants],
            *certificate.next.values(),
        ]
        for variable in variables(roots):
            self._add_variable(certificate, variable)
        return {
            "says": certificate.says,
            "k": certificate.k,
            "contract": contract,
            "bad": bad,
            "invariants": invariants,
        }

    def _term(self, certificate: Certificate, t: T) -> str:
        return self._translated(certificate, t).text

    def _translated(self, certificate: Certificate, t: T) -> Text:
        formula: Text = translate(self.script, t, lambda v: self._lookup(certificate, v), self._memo)
        return formula

    def _lookup(self, certificate: Certificate, v: T) -> Text:
        """Return the text of a variable: the value of a held variable, or a name that is declared once."""
        if v.val in certificate.held:
            formula: Text = literal(self.script, v, certificate.initial[v.val])
            return formula
        if v.val not in self._declared:
            self._declared[v.val] = self.script.declare(sort_of(v), v.val)
        return self._declared[v.val]

    def _add_variable(self, certificate: Certificate, v: T) -> None:
        """Add the initial value, the next value and the range of a variable, once."""
        if v.val in certificate.held:
            return
        declared = self._lookup(certificate, v)
        name, is_state = declared.text, v.val in certificate.next
        is_added = name in self.states or any(entry["of"] == name for entry in self.ranges)
        if is_added:
            return
        if is_state:
            next_term = certificate.next[v.val]
            formula = self._translated(certificate, next_term)
            formula = fit(self.script, formula, width(next_term), width(v)) if v.kind == INT else formula
            initial = literal(self.script, v, certificate.initial[v.val]).text
            self.states[name] = {"next": formula.text, "initial": initial}
        elif v.val in certificate.late:
            self.late[name] = literal(self.script, v, certificate.initial[v.val]).text
        for condition in interval_conditions(self.script, v, declared):
            self.ranges.append({"of": name, "term": condition.text, "state": is_state})
