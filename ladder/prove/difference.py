"""What an edit changes: two programs with the same inputs, compared value by value.

| answer | means |
|---|---|
| equal | equal in every run: not listed |
| now | after equal states and inputs, one scan may leave different values |
| later | only after a scan in which another value differed |

A value that is written by one program alone is listed, too. Each listed value has a run in which it differs,
done by both compiled programs, or none was found within the limits.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from .algebra.numbers import eq
from .algebra.terms import FALSE, T, and_, mk, not_, reach, var, variables
from .differing_runs import differs, random_runs
from .induction import Limits, prove
from .replaying import ScanOf
from .sharing import Occasions, found_alike, occasions_of, reached, root_of, roots_of, unlike_roots
from .solving.frames import Frame
from .solving.solver import UNSAT, Solver
from .system import RUN_ONLY, HeldNumber, Key, ProgramSystem, Runnable, ScanBounds, System, shown

LIMITS = Limits(scans=5, k=2, work=300_000, fuse=16_000, helped=False)
"""Limits for one value that random runs do not tell apart."""

BUDGET = 20_000_000
"""Limit of the work for all values, see `Solver`."""

NEW = "~new:"
"""Start of the names of the new program's own variables."""


@dataclass(frozen=True, slots=True)
class ChangedValue:
    """A value that can differ.

    Attributes:
        key: its place.
        now: whether one scan after equal states can make the difference.
        scans: a run after which it differs, confirmed on both programs; none was found if empty.
        inputs: inputs of a scan on which the difference depends.
    """

    key: Key
    now: bool
    scans: tuple[ScanOf, ...] = ()
    inputs: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Its name: the path, with the index of an array's element."""
        return shown(f"{self.key[0]}[{self.key[1]}]")


@dataclass(slots=True)
class Difference:
    """What differs.

    Attributes:
        changed: values that both programs have, in the order of their names.
        removed: values that only the old program writes.
        added: values that only the new program writes.
        compared: how many values both write.
        held: numbers and bits that nothing writes, and that are assumed to keep their values.
    """

    changed: list[ChangedValue] = field(default_factory=list)
    removed: list[str] = field(default_factory=list)
    added: list[str] = field(default_factory=list)
    compared: int = 0
    held: list[HeldNumber] = field(default_factory=list)

    def beyond(self, only: Iterable[str]) -> list[ChangedValue]:
        """Return what can differ besides some tags and their members."""
        allowed = tuple(name.upper() for name in only)
        starts = tuple(f"{name}{sign}" for name in allowed for sign in ".[")
        return [
            each for each in self.changed if each.name not in allowed and not each.name.startswith(starts)
        ]


def compare(
    old: Runnable,
    new: Runnable,
    bounds: ScanBounds = ScanBounds(),  # noqa: B008 - frozen
    *,
    free: Sequence[str] = (),
    written_outside: Sequence[str] = (),
    limits: Limits = LIMITS,
    budget: int = BUDGET,
) -> Difference:
    """Compare two programs, power-up to power-up, the key in run, with the same inputs in each scan.

    Raises:
        LadderError: what is not proved about, by name.
    """
    given = {"free": free, "written_outside": written_outside, "happenings": RUN_ONLY}
    before = ProgramSystem(old, bounds, **given)  # type: ignore[arg-type]
    after = ProgramSystem(new, bounds, **given, beside=before)  # type: ignore[arg-type]
    return _Comparison(before, after, limits, budget).difference()


@dataclass(slots=True)
class _Comparison:
    """Two problems on shared variables.

    Attributes:
        own: terms for variables of the new program that are not those of the old one.
        havocs: text of the instruction for each variable of what is not modeled.
        occasions: what such instructions found, of the old and the new program.
        unlike: tags that they name which may differ although no value of a scan's end does.
    """

    old: ProgramSystem
    new: ProgramSystem
    limits: Limits
    left: int
    own: dict[str, T] = field(default_factory=dict)
    havocs: dict[str, str] = field(default_factory=dict)
    memo: dict[int, T] = field(default_factory=dict)
    runs: dict[Key, tuple[ScanOf, ...]] = field(default_factory=dict)  # found by chance
    occasions: tuple[Occasions, Occasions] = ({}, {})
    unlike: set[str] = field(default_factory=set)

    def difference(self) -> Difference:
        """Compare."""
        mine, its = _states(self.old), _states(self.new)
        both = sorted(mine & its)
        shown_ones = [key for key in both if _is_shown(key)]
        result = Difference(compared=len(shown_ones))
        result.removed = sorted(_name(key) for key in mine - its if _is_shown(key))
        result.added = sorted(_name(key) for key in its - mine if _is_shown(key))
        self._keep_apart()
        now = self._now(both)
        dirty = self._ever(both, now | (mine ^ its))
        for key in sorted(dirty & its):
            v = self.new.machine.vars[key]
            self.own.setdefault(v.val, _own(v))
        self.memo.clear()
        system = self._together()
        result.held = self._held(system, both)
        asked = [key for key in shown_ones if key in dirty]
        self.runs = random_runs(self.old, self.new, asked)
        for key in asked:
            found = self._one(system, key, key in now)
            if found is not None:
                result.changed.append(found)
        return result

    # --- variables of the new program's own

    def _keep_apart(self) -> None:
        """Give the new program variables of its own, where type, role or initial value are not the same."""
        old, new = self.old, self.new
        for name, key in new.key_of.items():
            if name not in old.key_of:
                continue
            v = new.machine.vars[key]
            alike = v is old.machine.vars[old.key_of[name]] and old.role(name) == new.role(name)
            if not alike or old.initial.get(name) != new.initial.get(name):
                self.own[name] = _own(v)
        self._match_havocs()

    def _match_havocs(self) -> None:
        """Share what is not modeled between instructions of the same text: equal operands, equal results."""
        old, new = _by_instruction(self.old), _by_instruction(self.new)
        ours, theirs = self.occasions = occasions_of(self.old), occasions_of(self.new)
        apart = {
            text
            for text, variables_ in new.items()
            if [(v.kind, v.lo, v.hi) for v in old.get(text, [])] != [(v.kind, v.lo, v.hi) for v in variables_]
        }
        while True:
            self.memo.clear()
            for text, variables_ in new.items():
                pairs = zip(variables_, variables_ if text in apart else old[text], strict=True)
                self.own.update((v.val, _own(v) if text in apart else before) for v, before in pairs)
            texts = ours.keys() | theirs.keys()
            more = {
                text
                for text in texts - apart
                if not found_alike(ours.get(text, []), theirs.get(text, []), self._in_new)
            }
            if not more:
                break
            apart |= more
        for text, variables_ in new.items():
            self.havocs.update((self.own[v.val].val, text) for v in variables_)
        for text, before in old.items():
            self.havocs.update((v.val, text) for v in before)
        given = [each for found in self.occasions for listed in found.values() for each in listed]
        self.unlike = unlike_roots(self.old, self.new, given)
        self.unlike |= roots_of(each for each in given if each.text in apart)

    def _in_new(self, t: T) -> T:
        """Return a term of the new program with its own variables."""
        for each in reach([t]) if self.own else ():
            if each.id not in self.memo:
                if each.op == "var":
                    self.memo[each.id] = self.own.get(each.val, each)
                else:
                    args = tuple(self.memo[a.id] for a in each.args)
                    self.memo[each.id] = mk(each.op, args, each.kind, each.val, each.lo, each.hi)
        return self.memo[t.id] if self.own else t

    # --- which values can differ

    def _pair(self, key: Key) -> tuple[T, T]:
        """Return the value after a scan in both programs."""
        name = _variable(key)
        return self.old.next[name], self._in_new(self.new.next[name])

    def _differ(self, key: Key) -> T:
        one, other = self._pair(key)
        return FALSE if one is other else not_(eq(one, other))

    def _now(self, both: Sequence[Key]) -> set[Key]:
        """Return values that one scan can make different, after equal states."""
        solver = Solver(self.limits.fuse)
        frame = Frame(System(held=self.old.held & self.new.held, initial=self.old.initial), solver)
        found = set()
        for key in both:
            differ = self._differ(key)
            if differ is FALSE:
                continue
            before = solver.work
            if self.left <= 0 or solver.check(frame.term(differ)) != UNSAT:
                found.add(key)
            self.left -= solver.work - before
        return found

    def _ever(self, both: Sequence[Key], first: set[Key]) -> set[Key]:
        """Return those and all that depend on them, in any number of scans."""
        pairs = {key: self._pair(key) for key in both}
        order = reach([t for pair in pairs.values() for t in pair])
        dirty, apart = set(first), {v.val for v in self.own.values()} - set(self.havocs)
        while True:
            names = {_variable(key) for key in dirty} | apart | self._dirty_havocs(dirty)
            marked: set[int] = set()
            for t in order:
                if (t.op == "var" and t.val in names) or any(a.id in marked for a in t.args):
                    marked.add(t.id)
            more = {key for key, pair in pairs.items() if any(t.id in marked for t in pair)} - dirty
            if not more:
                return dirty
            dirty |= more

    def _dirty_havocs(self, dirty: set[Key]) -> set[str]:
        """Return what instructions compute that name a tag with a value that can differ."""
        own = {root_of(name) for name in self.own if name not in self.havocs}
        texts = reached({root_of(key[0]) for key in dirty} | own | self.unlike, self.occasions)
        return {name for name, text in self.havocs.items() if name.startswith(NEW) or text in texts}

    def _held(self, system: System, both: Iterable[Key]) -> list[HeldNumber]:
        """Return what is held and decides whether some values differ."""
        asked = [_variable(key) for key in both if self._differ(key) is not FALSE]
        cone = system.cone([self._differ(key) for key in both])
        found: dict[object, HeldNumber] = {}
        for problem in (self.old, self.new):
            names = {name.removeprefix(NEW) for name in cone} & problem.key_of.keys()
            roots = [problem.next[name] for name in asked]
            found |= {(each.key, each.bit): each for each in problem.held_numbers(names, roots)}
        return list(found.values())

    # --- runs

    def _together(self) -> System:
        """Return both programs as one system: what can't differ is shared."""
        old, new = self.old, self.new
        system = System(
            next=dict(old.next),
            initial=dict(old.initial),
            held=set(old.held),
            late=set(old.late),
            contract=and_(old.contract, self._in_new(new.contract)),
            key_of=dict(old.key_of),
            least_ms=old.least_ms,
        )
        for name, key in new.key_of.items():
            place = self.own[name].val if name in self.own else name
            if place in old.key_of:
                continue
            system.key_of[place], system.initial[place] = key, new.initial[name]
            if name in new.next:
                system.next[place] = self._in_new(new.next[name])
            system.held |= {place} if name in new.held else set()
            system.late |= {place} if name in new.late else set()
        return system

    def _one(self, system: System, key: Key, now: bool) -> ChangedValue | None:
        """Return how a value differs; None if it is proved equal in every run."""
        differ = self._differ(key)
        free = {v.val.removeprefix(NEW) for v in variables([differ]) if system.role(v.val) == "free"}
        places = self.new.key_of.keys() | self.old.key_of.keys()
        inputs = tuple(shown(name) for name in sorted(free & places))
        by_chance = self.runs.get(key, ())
        if self.left <= 0 or (by_chance and not now):
            return ChangedValue(key, now, by_chance, inputs)
        verdict = prove(system, differ, self.limits)
        self.left -= 1 + verdict.work
        if verdict and not by_chance and self.old.deep is FALSE and self.new.deep is FALSE:
            return None
        confirmed = verdict.scans and differs(self.old, self.new, verdict.scans, key)
        return ChangedValue(key, now, verdict.scans if confirmed else by_chance, inputs)


def _states(problem: ProgramSystem) -> set[Key]:
    return {problem.key_of[name] for name in problem.next if name in problem.key_of}


def _is_shown(key: Key) -> bool:
    return not key[0].startswith(("~", "S:")) and ".~" not in key[0]


def _by_instruction(problem: ProgramSystem) -> dict[str, list[T]]:
    """Return the variables of what is not modeled, in order, by the text of the instruction."""
    havocs = problem.machine.havocs
    known = {v.val: v for v in variables(problem.next.values()) if v.val in havocs}
    found: dict[str, list[T]] = {}
    for name, site in havocs.items():
        if name in known:
            found.setdefault(site.instruction, []).append(known[name])
    return found


def _variable(key: Key) -> str:
    return f"{key[0]}[{key[1]}]"


def _name(key: Key) -> str:
    return shown(_variable(key))


def _own(v: T) -> T:
    return var(NEW + v.val, v.kind, v.lo, v.hi)
