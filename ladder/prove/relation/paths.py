"""Paths through the Python code of an instruction, which fork at each decision and merge at the end."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ...model.errors import LadderFault
from ..algebra.meaning import BOOL
from ..algebra.terms import FALSE, T, all_of, any_of, const, ite, not_
from .places import Key
from .symbols import UnmodeledError, term_of

MOST_PATHS = 256
"""Maximum number of paths through one instruction."""

MOST_DECISIONS = 64
"""Maximum number of decisions on one path."""


class PathFault(Exception):  # noqa: N818 - control flow, not an error
    """Raised when a path ends in a major fault."""


class Decision(NamedTuple):
    """A condition, and whether it is true on a path."""

    condition: T
    truth: bool


@dataclass(slots=True)
class Path:
    """A path with its decisions, writes and result."""

    decided: list[Decision] = field(default_factory=list)
    written: dict[Key, T] = field(default_factory=dict)
    result: Any = None
    faulted: bool = False


class Paths:
    """Runs the paths of the current instruction."""

    def __init__(self) -> None:
        self.path: Path | None = None  # the current path
        self.overflows = const(0)  # faults noted on this path
        self._trail: list[Decision] = []  # planned for the current path, and those added to it
        self._depth = 0  # number of decisions made on the current path
        self._unknowns: dict[tuple[int, Hashable], T] = {}
        self._unknown_count = 0  # unknown values of this path

    def unknown(self, kind: Hashable, create: Callable[[], T]) -> T:
        """Return an unknown value. All paths share the value at this position.

        Paths exclude each other, so they can share values. They must share values, because each path repeats
        the decisions of the previous path with the same terms.

        Args:
            kind: identifies the value; different kinds never share a value.
            create: makes a new value.
        """
        if self.path is None:
            return create()
        position = self._unknown_count, kind
        self._unknown_count += 1
        if position not in self._unknowns:
            self._unknowns[position] = create()
        return self._unknowns[position]

    def decide(self, t: T) -> bool:
        """Decide a condition on this path as planned by `walk`, or as true if the condition is new."""
        if t.op == "const":
            return bool(t.val)
        if self.path is None:
            raise UnmodeledError("a truth is needed outside of an instruction")
        for decided, truth in self._trail[: self._depth]:
            if decided is t or decided is not_(t):
                return truth is (decided is t)
        if self._depth == len(self._trail):
            if self._depth == MOST_DECISIONS:
                raise UnmodeledError(f"more than {MOST_DECISIONS} decisions")
            self._trail.append(Decision(t, truth=True))
        decision = self._trail[self._depth]
        if decision.condition is not t:
            raise UnmodeledError("it makes other decisions when it is repeated")
        self._depth += 1
        return decision.truth

    def here(self) -> T:
        """Return the condition of this path so far."""
        return _condition_of(self._trail[: self._depth])

    def walk(self, run: Callable[[], Any]) -> list[Path]:
        """Run a function on every path; return the paths in depth-first order, true before false."""
        if self.path is not None:
            raise UnmodeledError("an instruction within an instruction")
        self._trail, self._unknowns, paths = [], {}, []
        try:
            while True:
                paths.append(self._run_path(run))
                while self._trail and not self._trail[-1].truth:
                    self._trail.pop()  # both truths are done
                if not self._trail:
                    return paths
                if len(paths) == MOST_PATHS:
                    raise UnmodeledError(f"more than {MOST_PATHS} paths")
                self._trail[-1] = self._trail[-1]._replace(truth=False)
        finally:
            self.path, self._depth = None, 0

    def _run_path(self, run: Callable[[], Any]) -> Path:
        """Run a function once, with the planned decisions; return the path that it took."""
        path = Path()
        self.path, self._depth, self._unknown_count, self.overflows = path, 0, 0, const(0)
        try:
            path.result = run()
        except (PathFault, LadderFault):
            path.faulted = True
        path.decided = list(self._trail)
        return path


def _condition_of(decided: list[Decision]) -> T:
    """Return the condition under which a path makes its decisions."""
    return all_of(condition if truth else not_(condition) for condition, truth in decided)


def written_by(paths: list[Path]) -> dict[Key, None]:
    """Return the places that any of the paths writes, in order."""
    return dict.fromkeys(key for path in paths for key in path.written)


def merged(paths: list[Path], value: Callable[[Path], T], *, all_: bool = False) -> T:
    """Return the value of the path that is taken.

    Args:
        all_: whether the values of faulting paths matter; if not, values of other paths can replace them.
    """
    counted = paths if all_ else [path for path in paths if not path.faulted]
    return _merged(counted or paths[:1], value, 0)


def _merged(paths: list[Path], value: Callable[[Path], T], depth: int) -> T:
    """Return the value of the path that is taken, among paths with the same first `depth` decisions."""
    if len(paths) == 1:
        return value(paths[0])
    split = sum(path.decided[depth].truth for path in paths)  # the paths with a true decision come first
    if split in (0, len(paths)):
        return _merged(paths, value, depth + 1)
    condition = paths[0].decided[depth].condition
    return ite(condition, _merged(paths[:split], value, depth + 1), _merged(paths[split:], value, depth + 1))


def faults_of(paths: list[Path]) -> T:
    """Return the condition under which the path that is taken faults."""
    return any_of(_condition_of(path.decided) for path in paths if path.faulted)


def result_of(path: Path) -> T:
    """Return the result of a path as a condition."""
    return FALSE if path.result is None else term_of(path.result, BOOL)
