"""What is not modeled, in two programs: where equal instructions get equal values, and so compute the same.

An instruction that the relation leaves open writes unknown values. Two programs share them if the text of the
instruction is the same, as often executed, and all that it names has the same terms where it runs: another
value may be overwritten before the scan ends. What it has from the scans before may still differ: its tags
begin with other values, or depend on something that differs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping

from .algebra.terms import T
from .relation.steps import UnmodeledStep
from .system import ProgramSystem

Occasions = Mapping[str, list[UnmodeledStep]]
"""What instructions found that are not modeled, in order, by their text."""

InNew = Callable[[T], T]
"""Returns a term of the new program with its own variables."""


def root_of(path: str) -> str:
    r"""Return the tag of a path, with its program.

    >>> root_of(r"\P.LOOP.OUT"), root_of("ROW[3]")
    ('\\P.LOOP', 'ROW')
    """
    names = 2 if path.startswith("\\") else 1
    return ".".join(path.split(".")[:names]).partition("[")[0]


def occasions_of(problem: ProgramSystem) -> Occasions:
    """Return what a program's instructions found that are not modeled."""
    found: dict[str, list[UnmodeledStep]] = defaultdict(list)
    for each in problem.machine.given:
        found[each.text].append(each)
    return found


def roots_of(given: Iterable[UnmodeledStep]) -> set[str]:
    """Return the tags that instructions name."""
    return {root_of(path) for each in given for path in each.paths}


def found_alike(old: list[UnmodeledStep], new: list[UnmodeledStep], in_new: InNew) -> bool:
    """Return whether instructions of one text found the same in this scan."""
    return len(old) == len(new) and all(
        a.paths == b.paths and _same(a, b, in_new) for a, b in zip(old, new, strict=True)
    )


def _same(old: UnmodeledStep, new: UnmodeledStep, in_new: InNew) -> bool:
    if old.values.keys() != new.values.keys() or old.lost.keys() != new.lost.keys():
        return False
    if any(t is not in_new(new.values[key]) for key, t in old.values.items()):
        return False
    lost = [pair for path in old.lost for pair in zip(old.lost[path], new.lost[path], strict=False)]
    return all(len(old.lost[path]) == len(new.lost[path]) for path in old.lost) and all(
        a[1].instruction == b[1].instruction and a[0] is in_new(b[0]) for a, b in lost
    )


def unlike_roots(old: ProgramSystem, new: ProgramSystem, given: Iterable[UnmodeledStep]) -> set[str]:
    """Return the tags of instructions that begin with other values, or become unknown elsewhere."""
    found = set()
    for path in {path for each in given for path in each.paths}:
        if not _begin_alike(old, new, path) or _losers(old, path) != _losers(new, path):
            found.add(root_of(path))
    return found


def _begin_alike(old: ProgramSystem, new: ProgramSystem, path: str) -> bool:
    ours, theirs = (each.lowered.layout.find(path) for each in (old, new))
    if ours is None or theirs is None or (ours.type, ours.dims) != (theirs.type, theirs.dims):
        return False
    both = (old.engine.memory, ours), (new.engine.memory, theirs)
    one, other = (repr(memory.values(leaf)) if memory.has(leaf) else "" for memory, leaf in both)
    return one == other


def _losers(problem: ProgramSystem, path: str) -> list[str]:
    return [site.instruction for _, site in problem.machine.lost_at(path)]


def reached(first: set[str], occasions: Iterable[Occasions]) -> set[str]:
    """Return the texts of instructions that name these tags, or one that another such instruction names."""
    roots, texts, more = set(first), set[str](), True
    named = [(text, roots_of(given)) for each in occasions for text, given in each.items()]
    while more:
        more = False
        for text, tags in named:
            if (text not in texts or not tags <= roots) and (text in texts or tags & roots):
                texts.add(text)
                roots |= tags
                more = True
    return texts
