"""Questions that need no property: what is dead, stuck, in conflict, never done, or faults.

| rule | is found if |
|---|---|
| `dead-rung` | proved: no output of a rung ever has power |
| `dead-leg` | proved: a contact never passes power, or always does; a leg adds nothing to the others |
| `never-on` | proved: a coil's bit is never 1 after a scan |
| `stuck` | proved: a coil's bit, once 1, is 1 after each later scan |
| `conflict` | refuted, by a run: two OTE of one bit write different values in one scan |
| `never-done` | proved: DN of a timer or counter is never 1 after a scan |
| `fault` | refuted, by a run: a major fault, a zero divisor or an overflow |
| `endless` | refuted, by a run: a loop does not end within the controller's watchdog |

What is to be proved is proved for any values of numbers that nothing writes: no finding depends on a recipe.
Random scans answer most questions, the solver many others without a history, induction some of the rest.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

from ...io_images.site import Site
from ..model.operands import Constant, Group, Place
from ..model.spec import InstructionKind
from ..state.lowered import LoweredLine, LoweredStep, Node, Parallel, steps_of
from .algebra.meaning import BOOL
from .algebra.numbers import bit
from .algebra.terms import FALSE, TRUE, T, and_, iff, not_, or_, variables
from .induction import Limits, Verdict, VerdictKind, prove
from .relation.symbols import term_of
from .solving.frames import Frame
from .solving.runs import Runs
from .solving.solver import UNSAT, Solver
from .system import ProgramSystem, System

PROVED_RULES = ("dead-rung", "dead-leg", "never-on", "stuck", "never-done")
"""Rules that find something by a proof; the others find it by a run."""

RULES = (*PROVED_RULES, "conflict", "fault", "endless")

LIMITS = Limits(scans=5, k=2, steps=2_000, total=10_000)
"""Limits for one question."""

BUDGET = 100_000
"""Limit of the solver's steps for all questions of a program."""

SCANS, RESTART = 30, 15
"""Random scans of each run of the relation, and after how many it starts again."""

PASSIVE = frozenset(("AFI", "NOP", "ONS", "OSR", "OSF"))
"""Contacts that are meant to pass never, always, or once."""

COILS = frozenset(("OTE", "OTL", "OTU"))

MOST_HELPED = 600
"""States of a program up to which invariants are sought for its questions."""

TIMED = frozenset(("TON", "TOF", "RTO", "CTU", "CTD", "CTUD", "TONR", "TOFR", "RTOR"))


@dataclass(frozen=True, slots=True)
class Question:
    """Whether a truth, of the values before a scan, can ever hold.

    Attributes:
        rule: what is found if it can't, or if it can.
        site: the instruction or rung.
        text: what is found, in words.
        bad: the truth.
        lives: a truth that can hold; else another finding says it all.
        fault: the site of the major fault that it is, or None.
    """

    rule: str
    site: Site
    text: str
    bad: T
    lives: T = TRUE
    fault: Site | None = None


@dataclass(frozen=True, slots=True)
class Finding:
    """An answer worth a line."""

    rule: str
    site: Site
    text: str
    verdict: Verdict


@dataclass(slots=True)
class Answers:
    """What was found, and how many questions each rule asked and left open."""

    findings: list[Finding] = field(default_factory=list)
    asked: Counter[str] = field(default_factory=Counter)
    open: Counter[str] = field(default_factory=Counter)


def ask(
    problem: ProgramSystem, rules: Sequence[str] = RULES, limits: Limits = LIMITS, budget: int = BUDGET
) -> Answers:
    """Answer the questions of some rules, in the order of the program.

    Args:
        problem: a program.
        rules: ids of rules.
        limits: for one question.
        budget: the solver's steps for all of them; what is left then is open.
    """
    questions = [each for each in _questions(problem) if each.rule in rules]
    if len(problem.next) > MOST_HELPED:
        limits = replace(limits, helped=False)
    return _Asking(problem, limits, budget, _possible(problem, questions)).answers(questions)


@dataclass(slots=True)
class _Asking:
    """Answers questions.

    Attributes:
        system: the problem with all numbers free that nothing writes.
        possible: truths that are known to hold in some scan.
        impossible: truths that are known to hold in none.
    """

    problem: ProgramSystem
    limits: Limits
    left: int
    possible: set[T]
    found: Answers = field(default_factory=Answers)
    system: System = field(init=False)
    impossible: set[T] = field(default_factory=set)

    def answers(self, questions: Sequence[Question]) -> Answers:
        """Answer all."""
        self.system = any_numbers(self.problem)
        self._find_impossible([each.bad for each in questions])
        dead_rungs: set[tuple[str, int | None]] = set()
        found: set[tuple[str, Site, str]] = set()
        for each in questions:
            if (each.rule, each.site, each.text) in found:
                continue  # another pass of a loop
            self.found.asked[each.rule] += 1
            place = each.site.routine, each.site.rung
            if each.rule == "dead-leg" and place in dead_rungs:
                continue
            verdict = self._proof(each.bad) if each.rule in PROVED_RULES else self._run(each)
            if verdict.kind is VerdictKind.UNKNOWN:
                self.found.open[each.rule] += 1
            elif (verdict.kind is VerdictKind.PROVED) is (each.rule in PROVED_RULES):
                if self._can_be(each.lives):
                    self.found.findings.append(Finding(each.rule, each.site, each.text, verdict))
                    found.add((each.rule, each.site, each.text))
                if each.rule == "dead-rung":
                    dead_rungs.add(place)
        return self.found

    def _find_impossible(self, truths: Sequence[T]) -> None:
        """Find the truths that no state and input makes true, whatever came before."""
        if not prove(self.system, FALSE, replace(self.limits, replays=False)):
            return  # the relation does not follow the program
        solver = Solver(self.limits.steps)
        frame = Frame(self.system, solver)
        for t in dict.fromkeys(truths):
            if t is FALSE:
                self.impossible.add(t)
            elif t not in self.possible and self.left > 0:
                before = solver.spent
                if solver.check(frame.term(t)) == UNSAT:
                    self.impossible.add(t)
                self.left -= 1 + solver.spent - before

    def _proof(self, t: T) -> Verdict:
        if t in self.impossible:
            return Verdict(VerdictKind.PROVED)
        if t in self.possible:
            return Verdict(VerdictKind.REFUTED)
        return self._decided(self.system, t, replace(self.limits, replays=False))

    def _run(self, question: Question) -> Verdict:
        if question.bad in self.impossible:
            return Verdict(VerdictKind.PROVED)
        return self._decided(self.problem, question.bad, self.limits, question.fault)

    def _decided(self, system: System, t: T, limits: Limits, fault: Site | None = None) -> Verdict:
        if self.left <= 0:
            return Verdict(blame=("the limit of steps for all questions",))
        verdict = prove(system, t, limits, fault=fault)
        self.left -= 1 + verdict.spent
        if verdict.kind is not VerdictKind.UNKNOWN and system is self.system:
            (self.impossible if verdict else self.possible).add(t)
        return verdict

    def _can_be(self, t: T) -> bool:
        return t is TRUE or self._proof(t).kind is not VerdictKind.PROVED


def any_numbers(problem: ProgramSystem) -> System:
    """Return the problem with all numbers free that nothing writes."""
    return System(
        next=problem.next,
        initial=problem.initial,
        held={name for name in problem.held if name.startswith(("~", "S:"))},
        late=problem.late,
        contract=problem.contract,
        deep=problem.deep,
        havocs=problem.havocs,
        key_of=problem.key_of,
        least_ms=problem.least_ms,
    )


def _possible(problem: ProgramSystem, questions: Sequence[Question]) -> set[T]:
    """Return truths that random scans from power-up made true."""
    asked = [t for t in dict.fromkeys(each.bad for each in questions) if t.op != "const"]
    found = {each.bad for each in questions if each.bad is TRUE}
    cone = {v.val: v for v in variables([*problem.next.values(), *asked, problem.contract])}
    runs, seen = Runs(problem, cone, asked, seed=1), [False] * len(asked)
    for number in range(SCANS):
        if number and number % RESTART == 0:
            runs.restart()
        watched, kept = runs.scan()
        seen = [before or bool((truths & kept).any()) for before, truths in zip(seen, watched, strict=True)]
    return found | {t for t, truth in zip(asked, seen, strict=True) if truth}


# --- the questions of a program


def _questions(problem: ProgramSystem) -> Iterator[Question]:
    lines = [
        line
        for routine in problem.lowered.routines.values()
        for line in routine.lines
        if any(step.site in problem.machine.passages for step in line.steps)
    ]
    for line in lines:
        yield from _of_line(problem, line)
    steps = [step for line in lines for step in line.steps]
    for step in steps:
        if step.name in TIMED and isinstance(step.operands[0], Group):
            yield from _of_timer(problem, step)
    coils: dict[str, list[LoweredStep]] = {}
    for step in steps:
        if step.name in COILS and _is_fixed(step.operands[0]):
            coils.setdefault(step.operands[0].text.upper(), []).append(step)
    for found in coils.values():
        yield from _of_coil(problem, found)
    yield from _faults(problem)


def _of_line(problem: ProgramSystem, line: LoweredLine) -> Iterator[Question]:
    passages, sites = problem.machine.passages, problem.lowered.sites
    outputs = [step for step in line.steps if step.kind is not InstructionKind.INPUT]
    if not outputs or sites[outputs[0].site].unit != "rung":
        return
    site = sites[outputs[0].site]
    reached = _any(each.before for step in outputs for each in passages.get(step.site, ()))
    yield Question("dead-rung", site, f"no output of {site.place} ever has power", reached)
    yield from _of_contacts(problem, line.nodes)


def _of_contacts(problem: ProgramSystem, nodes: tuple[Node, ...]) -> Iterator[Question]:
    for node in nodes:
        if isinstance(node, Parallel):
            for leg in node.legs:
                yield from _of_contacts(problem, leg)
            yield from _of_legs(problem, node)
        elif node.kind is InstructionKind.INPUT and node.name not in PASSIVE:
            found = problem.machine.passages.get(node.site, ())
            passed = _any(and_(each.before, each.after) for each in found)
            blocked = _any(and_(each.before, not_(each.after)) for each in found)
            site = problem.lowered.sites[node.site]
            always = f"{site.instruction} decides nothing: it passes whatever reaches it"
            yield Question("dead-leg", site, always, blocked, passed)
            yield Question("dead-leg", site, f"{site.instruction} never passes", passed, blocked)


def _of_legs(problem: ProgramSystem, branch: Parallel) -> Iterator[Question]:
    """Ask for legs that decide nothing: another one has power whenever they have."""
    if any(step.kind is not InstructionKind.INPUT for step in steps_of((branch,))):
        return
    for number, leg in enumerate(branch.legs):
        if leg:
            alone = on = FALSE
            for active, behind in problem.machine.legs.get(id(branch), ()):
                others = _any(power for place, power in enumerate(behind) if place != number)
                on = or_(on, and_(active, behind[number]))
                alone = or_(alone, and_(and_(active, behind[number]), not_(others)))
            site = problem.lowered.sites[steps_of(leg)[0].site]
            text = f"the leg of {site.instruction} decides nothing: another one has power, too"
            yield Question("dead-leg", site, text, alone, on)


def _of_timer(problem: ProgramSystem, step: LoweredStep) -> Iterator[Question]:
    done = step.operands[0].member("DN")
    if _is_fixed(done):
        site, text = problem.lowered.sites[step.site], step.operands[0].text
        yield Question("never-done", site, f"{text} is never done", bit_after(problem, done))


def _of_coil(problem: ProgramSystem, steps: Sequence[LoweredStep]) -> Iterator[Question]:
    place: Place = steps[0].operands[0]
    sites, after = problem.lowered.sites, bit_after(problem, place)
    on = next((step for step in steps if step.name != "OTU"), None)
    if on is not None:
        site, falls = sites[on.site], and_(bit_before(problem, place), not_(after))
        yield Question("never-on", site, f"{place.text} is never on", after)
        yield Question("stuck", site, f"{place.text} is never off again once it is on", falls, after)
    for one, other in combinations([step for step in steps if step.name == "OTE"], 2):
        where = sites[one.site].place
        text = f"{place.text}: the coils here and in {where} write different values in one scan"
        yield Question("conflict", sites[other.site], text, _disagree(problem, one, other))


def _disagree(problem: ProgramSystem, one: LoweredStep, other: LoweredStep) -> T:
    passages = problem.machine.passages
    return _any(
        and_(and_(a.active, b.active), not_(iff(a.power, b.power)))
        for a in passages.get(one.site, ())
        for b in passages.get(other.site, ())
    )


def _faults(problem: ProgramSystem) -> Iterator[Question]:
    sites, machine = problem.lowered.sites, problem.machine
    for number, condition in machine.faults:
        site = sites[number]
        yield Question("fault", site, f"{site.instruction}: a major fault", condition, fault=site)
    for (number, kind), condition in machine.fault_log.minor.items():  # type: ignore[attr-defined]
        yield Question("fault", sites[number], f"{sites[number].instruction}: {kind}", condition)
    if problem.deep is not FALSE:
        for site, name, why in machine.cut:
            yield Question("endless", site, f"{name}: {why}", problem.deep, fault=site)


def _any(truths: Iterable[T]) -> T:
    found = FALSE
    for each in truths:
        found = or_(found, each)
    return found


# --- bits


def _is_fixed(place: Any) -> bool:
    """Whether an operand is one bit at a fixed place of the program's own."""
    return (
        isinstance(place, Place)
        and not place.leaf.root
        and place.fixed_index is not None
        and (place.bit is None or isinstance(place.bit, Constant))
    )


def bit_after(problem: ProgramSystem, place: Place) -> T:
    """Return the term of a bit after a scan."""
    return term_of(problem.machine.get(place), BOOL)


def bit_before(problem: ProgramSystem, place: Place) -> T:
    """Return the term of a bit before a scan."""
    word = problem.now((place.leaf.path.upper(), place.fixed_index or 0))
    return bit(word, int(place.bit.value)) if isinstance(place.bit, Constant) else word
