"""The values that an edit can change, found by comparing two programs with the same inputs.

| answer | meaning |
|---|---|
| equal | equal in every run: not listed |
| now | from equal states and inputs, one scan can produce different values |
| later | different only after another value has differed in an earlier scan |

The comparison covers all values that exist in both programs and that at least one of them writes. Values that
exist in only one program are listed. For a value that can differ, the answer includes a run that both
compiled programs confirm, unless the search finds no run within its limits. Runs are compared up to the first
major fault. A fault in only one program is also a difference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from .algebra.numbers import same
from .algebra.terms import FALSE, TRUE, T, and_, mk, not_, reach, replaced, variables
from .differing_runs import FAULT, differs, random_runs
from .induction import Limits, prove
from .relation.shapes import form_of
from .replaying import ScanOf, scenario
from .sharing import NEW, SharedUnknowns, deciding, own
from .solving.frames import Frame
from .solving.solver import SAT, UNSAT, Solver
from .system import (
    RUN_ONLY,
    STOPPED,
    HeldNumber,
    Key,
    ProgramSystem,
    Runnable,
    ScanBounds,
    System,
    name_of,
    shown,
)

LIMITS = Limits(scans=5, k=2, work=300_000, fuse=16_000, helped=False)
"""Limits for each value that is equal in all random runs."""

IsOutput = Callable[[Key], bool]

BUDGET = 20_000_000
"""Work limit for all values together; see `Solver`."""


@dataclass(frozen=True, slots=True)
class ChangedValue:
    """A value that can differ.

    Attributes:
        key: the value's place; `FAULT` if the difference is a major fault that stops only one of the
            programs.
        now: whether the value can differ after one scan from equal states.
        scans: a run after which it differs, confirmed on both programs; empty if no run was found.
        inputs: the inputs of a scan on which the difference depends.
    """

    key: Key
    now: bool
    scans: tuple[ScanOf, ...] = ()
    inputs: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The path, with the index of an array element."""
        return shown(name_of(self.key))


@dataclass(slots=True)
class Difference:
    """The differences between two programs.

    Attributes:
        changed: values that exist in both programs and can differ, in the order of their names.
        fault: a major fault that can stop only one of the programs, or None.
        removed: values that only the old program writes.
        added: values that only the new program writes.
        uncompared: paths of arrays that an instruction without a model writes beyond the limit of elements.
        unfollowed: places where the relation does not follow the programs; after them, any value can differ.
        compared: number of values that are compared.
        held: numbers and bits that nothing writes; they are assumed to keep their values.
    """

    changed: list[ChangedValue] = field(default_factory=list)
    fault: ChangedValue | None = None
    removed: list[str] = field(default_factory=list)
    added: list[str] = field(default_factory=list)
    uncompared: list[str] = field(default_factory=list)
    unfollowed: tuple[str, ...] = ()
    compared: int = 0
    held: list[HeldNumber] = field(default_factory=list)


def compare(
    old: Runnable,
    new: Runnable,
    bounds: ScanBounds = ScanBounds(),  # noqa: B008 - frozen
    *,
    free: Sequence[str] = (),
    written_outside: Sequence[str] = (),
    is_output: IsOutput = lambda _key: True,
) -> Difference:
    """Compare two programs from power-up, with the key in run and the same inputs in each scan.

    Args:
        is_output: returns whether a value that either program writes is compared.

    Raises:
        LadderError: a program uses a feature that proofs don't support; the message names the feature.
    """
    system_of = partial(
        ProgramSystem, bounds=bounds, free=free, written_outside=written_outside, happens=RUN_ONLY
    )
    old_system = system_of(old)
    new_system = system_of(new, beside=old_system)
    written_by_one = _written_by_one(old_system, new_system)
    if written_by_one:
        old_system = system_of(old, kept=written_by_one)
        new_system = system_of(new, beside=old_system, kept=written_by_one)
    return compared(old_system, new_system, is_output=is_output)


def compared(
    old: ProgramSystem,
    new: ProgramSystem,
    limits: Limits = LIMITS,
    budget: int = BUDGET,
    is_output: IsOutput = lambda _key: True,
) -> Difference:
    """Compare two systems that only scan. The second system shares the terms of the first."""
    return _Comparison(old, new, limits, budget, is_output).difference()


@dataclass(slots=True)
class _Comparison:
    """Compares two systems on shared variables.

    Attributes:
        budget_left: the remaining work limit of the comparison; see `Solver`.
        replacements: terms that replace variables of the new program that it does not share with the old one.
        unlike: the replacements for values of the program.
        unshared: names of unknown values that are not shared; see `SharedUnknowns.match`.
    """

    old: ProgramSystem
    new: ProgramSystem
    limits: Limits
    budget_left: int
    is_output: IsOutput
    replacements: dict[str, T] = field(default_factory=dict)
    unlike: dict[str, T] = field(default_factory=dict)
    unshared: set[str] = field(default_factory=set)
    memo: dict[int, T] = field(default_factory=dict)
    runs: dict[Key, tuple[ScanOf, ...]] = field(default_factory=dict)  # found by random runs
    unknowns: SharedUnknowns = field(init=False)
    base: _Base = field(init=False)

    def __post_init__(self) -> None:
        self.unknowns = SharedUnknowns(self.old, self.new)

    def difference(self) -> Difference:
        """Compare the systems; skip the search if form, types and initial values are the same."""
        old, new = _written(self.old), _written(self.new)
        common = self._common_keys(old | new)
        outputs = self._outputs(key for key in common if key != FAULT)
        result = Difference(compared=len(outputs))
        result.removed = sorted(map(_name, self._outputs(old - new)))
        result.added = sorted(map(_name, self._outputs(new - old)))
        if form_of(self.old.lowered) == form_of(self.new.lowered) and self._have_equal_values():
            return result
        result.uncompared = sorted({*self.old.machine.partly_lost, *self.new.machine.partly_lost})
        result.unfollowed = (*self._unfollowed(self.old), *self._unfollowed(self.new))
        self._keep_apart(common)
        now = set(common) if result.unfollowed else self._differing_now(common)
        dirty = self._ever_differing(common, now)
        self._add_changes(result, common, [key for key in (*outputs, FAULT) if key in dirty], now, dirty)
        return result

    def _outputs(self, keys: Iterable[Key]) -> list[Key]:
        """Return the values that are compared."""
        return [key for key in keys if _is_shown(key) and self.is_output(key)]

    def _add_changes(
        self,
        result: Difference,
        common: Sequence[Key],
        open_keys: Sequence[Key],
        now_keys: set[Key],
        dirty: set[Key],
    ) -> None:
        """Decide each value; add the values that are not proved equal, and the assumptions of the proofs.

        Args:
            open_keys: values that can possibly differ.
            now_keys: values that can possibly differ after one scan from equal states.
            dirty: all values that can possibly differ in any scan.
        """
        for key in sorted(dirty - {FAULT}):
            variable = self.new.machine.vars[key]
            self.unlike.setdefault(variable.val, own(variable))
        self._match()
        system = self._together()
        self.base = _Base(system, self.limits, [self._differ(key) for key in dirty])
        result.held = self._deciding_held_numbers(system, common)
        self.runs = random_runs(self.old, self.new, open_keys)
        for key in open_keys:
            change = self._changed(system, key, now=key in now_keys, surely=not result.unfollowed)
            if change is not None and key == FAULT:
                result.fault = change
            elif change is not None:
                result.changed.append(change)

    def _common_keys(self, written: Iterable[Key]) -> list[Key]:
        """Return the given values that exist in both programs, and `FAULT` if either program can fault."""
        common = []
        for key in sorted(written):
            leaves = [side.lowered.layout.find(key[0]) for side in (self.old, self.new)]
            if all(leaf is not None and key[1] < leaf.size for leaf in leaves):
                common.append(key)
                for problem in (self.old, self.new):
                    problem.after(key)  # creates the term, so that the state has the key
        if any(STOPPED in side.next for side in (self.old, self.new)):
            common.append(FAULT)
        return common

    def _have_equal_values(self) -> bool:
        """Return whether both programs have the same values, with the same types and initial values."""
        leaves = [problem.lowered.layout.leaves for problem in (self.old, self.new)]
        return leaves[0].keys() == leaves[1].keys() and all(
            (leaf.type, leaf.dims, leaf.slot) == (other_leaf.type, other_leaf.dims, other_leaf.slot)
            and _initial(self.old, path) == _initial(self.new, path)
            for (path, leaf), other_leaf in zip(leaves[0].items(), leaves[1].values(), strict=True)
        )

    def _unfollowed(self, problem: ProgramSystem) -> tuple[str, ...]:
        """Return the places where the relation does not follow a program; () if no run reaches any."""
        if problem.deep is FALSE or prove(problem, problem.deep, replace(self.limits, replays=False)):
            return ()
        return problem.limits_met()

    # --- variables that are not shared

    def _keep_apart(self, common: Sequence[Key]) -> None:
        """Don't share variables whose type, role or initial value differs between the programs."""
        old, new = self.old, self.new
        for name, key in new.key_of.items():
            if name not in old.key_of:
                continue
            variable = new.machine.vars[key]
            is_alike = variable is old.machine.vars[old.key_of[name]] and old.role(name) == new.role(name)
            if not is_alike or repr(old.initial.get(name)) != repr(new.initial.get(name)):
                self.unlike[name] = own(variable)
        for name in new.next.keys() - new.key_of.keys():
            self.unlike[name] = mk("var", (), TRUE.kind, NEW + name)
        self._match()
        strict = set(self.unknowns.strict())
        if strict:
            touched = self._ever_differing(common, {key for key in common if self._differ(key) is not FALSE})
            names = {name_of(key) for key in touched} | self.unlike.keys()
            self.unshared = strict & self._depending(names)
            self._match()

    def _match(self) -> None:
        """Choose the variables for unknown values, either shared with the old program or new."""
        self.replacements = dict(self.unlike)
        self.memo.clear()
        self.unknowns.match(self.replacements, self._in_new, self.unshared)

    def _in_new(self, t: T) -> T:
        """Return a term of the new program with `replacements` for its variables."""
        return replaced(t, self.replacements, self.memo)

    # --- which values can differ

    def _pair(self, key: Key) -> tuple[T, T]:
        """Return the value after a scan in both programs."""
        old, new = (_after(problem, key) for problem in (self.old, self.new))
        return old, self._in_new(new)

    def _differ(self, key: Key) -> T:
        """Return the condition under which a value differs after a scan; TRUE if its kinds differ."""
        old, new = self._pair(key)
        return TRUE if old.kind != new.kind else not_(same(old, new))

    def _differing_now(self, common: Sequence[Key]) -> set[Key]:
        """Return the values that can differ after one scan that begins with equal states."""
        solver = Solver(self.limits.fuse)
        frame = Frame(System(held=self.old.held & self.new.held, initial=self.old.initial), solver)
        for _, fact in self.unknowns.facts:
            solver.state(frame.term(fact))
        keys = set()
        for key in common:
            differ = self._differ(key)
            if differ is FALSE:
                continue
            work_before = solver.work
            if self.budget_left <= 0 or solver.check(frame.term(differ)) != UNSAT:
                keys.add(key)
            self.budget_left -= solver.work - work_before
        return keys

    def _ever_differing(self, common: Sequence[Key], first: set[Key]) -> set[Key]:
        """Return the given values and all values that depend on them after any number of scans."""
        pairs = {key: self._pair(key) for key in common}
        dirty, apart = set(first), {variable.val for variable in self.unlike.values()}
        while True:
            names = {name_of(key) for key in dirty} | apart
            names |= self._depending(names)
            order = reach([term for pair in pairs.values() for term in pair])
            marked = _marked(order, names)
            added = {key for key, pair in pairs.items() if any(term.id in marked for term in pair)} - dirty
            if not added:
                return dirty
            dirty |= added

    def _depending(self, names: set[str]) -> set[str]:
        """Return the unknown values that depend on some variables, directly or indirectly."""
        depending: set[str] = set()
        order = reach([term for name in self.unknowns.known for term in deciding(self.unknowns.known, name)])
        while True:
            marked = _marked(order, names | depending)
            added = {
                name
                for name in self.unknowns.known.keys() - depending
                if any(term.id in marked for term in deciding(self.unknowns.known, name))
            }
            if not added:
                return depending
            depending |= added

    def _deciding_held_numbers(self, system: System, common: Iterable[Key]) -> list[HeldNumber]:
        """Return the held values on which differences of the given values depend."""
        differing = {key: self._differ(key) for key in common}
        differing_keys = [key for key, differ in differing.items() if differ is not FALSE]
        cone = system.cone(differing.values())
        held_numbers: dict[object, HeldNumber] = {}
        for problem in (self.old, self.new):
            names = {name.removeprefix(NEW) for name in cone} & problem.key_of.keys()
            roots = [_after(problem, key) for key in differing_keys]
            held_numbers |= {
                (number.key, number.bit): number for number in problem.held_numbers(names, roots)
            }
        return list(held_numbers.values())

    # --- runs

    def _together(self) -> System:
        """Return both programs as one system that shares the values that can't differ."""
        old, new = self.old, self.new
        system = System(
            next=dict(old.next),
            initial=dict(old.initial),
            held=set(old.held),
            late=set(old.late),
            contract=and_(old.contract, self._in_new(new.contract)),
            facts=list(self.unknowns.facts),
            key_of=dict(old.key_of),
            least=old.least,
            tick_ns=old.tick_ns,
        )
        for name in {**new.key_of, **new.next}:
            shared_name = self.replacements[name].val if name in self.replacements else name
            if shared_name in old.key_of:
                continue
            if name in new.key_of:
                system.key_of[shared_name] = new.key_of[name]
            system.initial[shared_name] = new.initial[name]
            if name in new.next:
                system.next[shared_name] = self._in_new(new.next[name])
            if name in new.held:
                system.held.add(shared_name)
            if name in new.late:
                system.late.add(shared_name)
        return system

    def _changed(self, system: System, key: Key, *, now: bool, surely: bool) -> ChangedValue | None:
        """Return how a value differs; None if it is proved equal in every run.

        Args:
            surely: whether the relation is known to follow both programs.
        """
        differ = self._differ(key)
        free = {
            variable.val.removeprefix(NEW)
            for variable in variables([differ])
            if system.role(variable.val) == "free"
        }
        names = self.new.key_of.keys() | self.old.key_of.keys()
        inputs = tuple(shown(name) for name in sorted(free & names))
        by_chance = self.runs.get(key, ())
        if self.budget_left <= 0 or (by_chance and not now):
            return ChangedValue(key, now, by_chance, inputs)
        work_before = self.base.work
        scans = self.base.run_to(differ)
        self.budget_left -= self.base.work - work_before
        if scans is None:
            verdict = prove(system, differ, self.limits)
            self.budget_left -= 1 + verdict.work
            if verdict and not by_chance and surely:
                return None
            scans = verdict.scans
        confirmed = scans and differs(self.old, self.new, scans, key)
        return ChangedValue(key, now, scans if confirmed else by_chance, inputs)


class _Base:
    """A search for runs from power-up. All values share one solver, so each scan is translated only once.

    Args:
        system: both programs.
        limits: limits of each question.
        roots: all conditions for which runs can be searched.
    """

    def __init__(self, system: System, limits: Limits, roots: Sequence[T]) -> None:
        self._system, self._limits, self._roots = system, limits, roots
        self._solver = Solver(limits.fuse)
        self._frames: list[Frame] = []

    @property
    def work(self) -> int:
        """Work done by the questions so far; see `Solver`."""
        return self._solver.work

    def run_to(self, t: T) -> tuple[ScanOf, ...] | None:
        """Return a run whose last scan makes a condition true; () if the fuse blows, None if no run does."""
        for number in range(self._limits.scans):
            frame = self._frame(number)
            answer = self._solver.check(frame.term(t))
            if answer == SAT:
                return scenario(self._system, [scan.values() for scan in frame])
            if answer != UNSAT:
                return ()
        return None

    def _frame(self, number: int) -> Frame:
        """Return a scan by its number, from 0. Create the scan if its number follows the last created one."""
        if number == len(self._frames):
            previous = self._frames[-1] if self._frames else None
            with self._system.narrowing(self._roots):
                self._frames.append(Frame(self._system, self._solver, previous, first=previous is None))
        return self._frames[number]


def _written_by_one(old: ProgramSystem, new: ProgramSystem) -> set[str]:
    """Return the paths of values that one program writes and that are free inputs of the other program."""
    old_keys, new_keys = _written(old), _written(new)
    return _free_paths(old, new_keys - old_keys) | _free_paths(new, old_keys - new_keys)


def _free_paths(problem: ProgramSystem, keys: Iterable[Key]) -> set[str]:
    """Return the paths of values that a program has and that are free in each scan."""
    find = problem.lowered.layout.find
    return {key[0] for key in keys if find(key[0]) is not None and problem.role(name_of(key)) == "free"}


def _written(problem: ProgramSystem) -> set[Key]:
    """Return the values that a program can write."""
    states = {problem.key_of[name] for name in problem.next if name in problem.key_of}
    return states | set(problem.machine.written)


def _after(problem: ProgramSystem, key: Key) -> T:
    """Return the value after a scan; for `FAULT`, whether a major fault has stopped the program."""
    if key == FAULT:
        return problem.next.get(STOPPED, FALSE)
    name = name_of(key)
    return problem.next[name] if name in problem.next else problem.machine.state[key]


def _marked(order: Sequence[T], names: set[str]) -> set[int]:
    """Return the ids of the terms in `order`, operands first, that depend on some variables."""
    marked: set[int] = set()
    for term in order:
        if (term.op == "var" and term.val in names) or any(argument.id in marked for argument in term.args):
            marked.add(term.id)
    return marked


def _initial(problem: ProgramSystem, path: str) -> str:
    """Return the initial values of a tag as text; "" if the memory does not contain the tag."""
    memory, leaf = problem.engine.memory, problem.lowered.layout.leaf(path)
    return repr(memory.values(leaf)) if memory.has(leaf) else ""


def _is_shown(key: Key) -> bool:
    """Return whether a place is a visible tag, not a hidden place or a system flag."""
    return not key[0].startswith(("~", "S:")) and ".~" not in key[0]


def _name(key: Key) -> str:
    return shown(name_of(key))
