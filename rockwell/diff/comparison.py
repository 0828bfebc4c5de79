"""The differences of two outlines.

| kind | what |
|---|---|
| added, removed | an item or a step that one version has |
| changed | fields of an item; a step that is alike; a comment |
| moved | a rung or a line at another place in the order of execution |
| renamed | an item with the same content, a tag with the same uses |

The order of named items, dates, authors, blanks and places on a sheet are listed apart: they change nothing
that runs.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from .alignment import longest_chain
from .outline import ELEMENT, CommonPart, Field, Item, Step, canonical_lines, place_of
from .pairing import Pairing, paired, without_followers
from .renames import TAGS, renamed, with_new_names

ADDED, REMOVED, CHANGED, MOVED, RENAMED = "added", "removed", "changed", "moved", "renamed"

MOST_LINES = 100
"""Maximum lines of a difference that are printed."""

ORDERED = frozenset({"parameter"})
"""Items whose order is the order of a call's operands."""

ORDER, DATES, LAYOUT = (
    "the order of",
    "dates, authors and options of",
    "blanks and places on the sheet of",
)
"""Changes that are listed apart from the differences."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two versions."""

    kind: str  # `ADDED`, `REMOVED`, `CHANGED`, `MOVED` or `RENAMED`
    what: str  # "rung", "line", "element", "comment", or what an item is: "tag", "routine", "data type", …
    owner: str  # program or add-on, and routine; "" for the controller
    name: str  # its name, or "rung 3"
    line: int  # its line in the new file; of a removal, in the old file
    before: str  # the old text, "" for additions
    after: str  # the new text, "" for removals
    was: str = ""  # the old name of a renamed item, or the old place of a moved step if that differs
    old: tuple[Step, ...] = ()  # steps of the old version that are drawn
    new: tuple[Step, ...] = ()
    head: str = ""  # text of an added or removed item, without these steps

    @property
    def where(self) -> str:
        """Its owner and its name, as text."""
        return ", ".join(filter(None, (self.owner, self.name)))

    @property
    def heading(self) -> str:
        """A line that says what differs."""
        numbered = self.name.startswith(f"{self.what} ")
        subject = self.name if numbered else " ".join(filter(None, (self.what, self.name)))
        if self.what == "comment":
            subject = f"comment of {self.name}"
        old_text = f", was {self.was}" if self.was else ""
        return f"{subject} {self.kind}{old_text} (line {self.line})"

    def lines(self) -> Iterator[str]:
        """Yield it as lines of text."""
        yield self.heading
        if self.kind == MOVED:
            yield from _some("    ", self.after)
            return
        yield from _some("  - ", self.before)
        yield from _some("  + ", self.after)

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {
            **{name: getattr(self, name) for name in ("kind", "what", "where", "line", "was")},
            "before": self.before,
            "after": self.after,
        }


def _some(mark: str, text: str) -> Iterator[str]:
    lines = text.splitlines()
    yield from (f"{mark}{line}" for line in lines[:MOST_LINES])
    if len(lines) > MOST_LINES:
        yield f"{mark}… {len(lines) - MOST_LINES:,} more lines"


@dataclass(frozen=True, slots=True)
class Comparison:
    """All differences between two versions, and the changes that are listed apart."""

    differences: tuple[Difference, ...]
    apart: tuple[str, ...]

    def lines(self) -> Iterator[str]:
        """Yield it as lines of text, grouped by program and routine."""
        for owner, group in self.by_owner().items():
            indent = "  " if owner else ""
            yield from filter(None, [owner])
            yield from (f"{indent}{line}" for difference in group for line in difference.lines())
        yield self.summary
        yield from (f"not counted: {note}" for note in self.apart)

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {
            "differences": [difference.as_json() for difference in self.differences],
            "apart": list(self.apart),
        }

    def by_owner(self) -> dict[str, list[Difference]]:
        """Return the differences by program and routine, starting with the controller's."""
        groups: defaultdict[str, list[Difference]] = defaultdict(list)
        for difference in self.differences:
            groups[difference.owner].append(difference)
        return dict(sorted(groups.items(), key=lambda group: bool(group[0])))

    @property
    def summary(self) -> str:
        """The differences in one line: `3 differences: 1 tag added, 2 rungs changed`."""
        counts = Counter((difference.what, difference.kind) for difference in self.differences)
        parts = [f"{count} {noun}{'s'[: count > 1]} {kind}" for (noun, kind), count in counts.items()]
        total = len(self.differences)
        return f"{total:,} difference{'s'[: total > 1]}: {', '.join(parts)}" if total else "no difference"


def compared(old: Item, new: Item) -> Comparison:
    """Compare two outlines."""
    comparer = _Comparer()
    comparer.item(old, new, "")
    return Comparison(tuple(comparer.differences()), tuple(comparer.apart_lines()))


@dataclass(slots=True)
class _Scope:
    """Items and steps of a program, an add-on or the controller, kept until its renamed tags are known."""

    old: list[Item] = field(default_factory=list)  # removed items
    new: list[Item] = field(default_factory=list)  # added items
    before: list[Step] = field(default_factory=list)
    after: list[Step] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Routine:
    """A pair of routines; their steps are compared last."""

    owner: str
    old: Item
    new: Item


@dataclass(frozen=True, slots=True)
class _One:
    """An item that only one version has."""

    owner: str
    kind: str
    item: Item


class _Comparer:
    """Compares items, then tags by their uses, then steps."""

    def __init__(self) -> None:
        self._found: list[Difference | _Routine | _One] = []
        self._scopes: defaultdict[str, _Scope] = defaultdict(_Scope)
        self._apart: defaultdict[str, list[str]] = defaultdict(list)

    # --- items

    def item(self, old: Item, new: Item, owner: str) -> None:
        """Compare two items with the same name, or an item and its renamed version."""
        place = place_of(owner, new)
        self._fields(old, new, owner)
        if old.dates != new.dates:
            self._apart[DATES].append(place or f"the {new.what}".replace("export", "file"))
        if old.steps or new.steps:
            self._found.append(_Routine(place, old, new))
            for scope in {"", owner}:
                self._scopes[scope].before += old.steps
                self._scopes[scope].after += new.steps
        self._items(old.items, new.items, place)

    def _fields(self, old: Item, new: Item, owner: str) -> None:
        before, after = _different(old.fields, new.fields)
        if not before and not after:
            before, after = _different(old.details, new.details)
        for fields, order in zip((before, after), _orders_of_members(old, new), strict=False):
            fields.append(f"order of members = {order}")
        if before or after:
            texts = "\n".join(before), "\n".join(after)
            self._found.append(Difference(CHANGED, new.what, owner, new.name, new.line, *texts))

    def _items(self, old: Sequence[Item | CommonPart], new: Sequence[Item | CommonPart], place: str) -> None:
        old, new, pairs = _without_shared(old, new)
        old_places, new_places = _by_place(old), _by_place(new)
        same_keys = _same_key(old_places, new_places)
        pairs |= same_keys
        added = [k for k in new_places if k not in same_keys]
        removed = sorted(old_places.keys() - same_keys.values())
        for k, i in _same_content(old_places, removed, new_places, added).items():
            pairs[k] = i
            added.remove(k)
            removed.remove(i)
            old_name, item = old_places[i].name, new_places[k]
            self._found.append(Difference(RENAMED, item.what, place, item.name, item.line, "", "", old_name))
        self._orders([part.what for part in new], pairs, new, place)
        self._one_sided(place, REMOVED, [old_places[i] for i in removed])
        for k, item in new_places.items():
            if k in pairs and item.name.upper() == old_places[pairs[k]].name.upper():
                self.item(old_places[pairs[k]], item, place)
            elif k not in pairs:
                self._one_sided(place, ADDED, [item])

    def _one_sided(self, owner: str, kind: str, items: Sequence[Item]) -> None:
        for item in items:
            self._found.append(_One(owner, kind, item))
            scope = self._scopes[owner]
            (scope.old if kind == REMOVED else scope.new).append(item)

    def _orders(
        self, kinds: Sequence[str], pairs: dict[int, int], new: Sequence[Item | CommonPart], place: str
    ) -> None:
        by_kind: defaultdict[str, list[tuple[int, int]]] = defaultdict(list)
        for k in sorted(pairs):
            by_kind[kinds[k]].append((k, pairs[k]))
        for noun, same_kind in by_kind.items():
            if len(longest_chain(same_kind)) == len(same_kind):
                continue
            if noun in ORDERED:
                names = [_name(new[k]) for k, _ in same_kind]
                old_names = [_name(new[k]) for k, _ in sorted(same_kind, key=lambda pair: pair[1])]
                before, after = (f"order of {noun}s = {', '.join(order)}" for order in (old_names, names))
                line = new[same_kind[0][0]].line
                self._found.append(Difference(CHANGED, "add-on", "", place, line, before, after))
            else:
                self._apart[ORDER].append(f"{noun}s of {place}" if place else f"{noun}s")

    # --- tags, then steps

    def differences(self) -> Iterator[Difference]:
        """Yield the differences in the order of the new version."""
        names = {
            owner: renamed(scope.old, scope.new, scope.before, scope.after)
            for owner, scope in self._scopes.items()
        }
        for entry in self._found:
            if isinstance(entry, Difference):
                yield entry
            elif isinstance(entry, _One):
                yield from _one(entry, names.get(entry.owner, {}))
            else:
                # the tags of the routine's program hide the controller's
                program = entry.owner.rpartition(", ")[0]
                yield from self._steps(entry, {**names.get("", {}), **names.get(program, {})})

    def _steps(self, routine: _Routine, names: dict[str, Item]) -> Iterator[Difference]:
        old_steps = [with_new_names(step, names) for step in routine.old.steps]
        for pair in without_followers(paired(old_steps, routine.new.steps)):
            yield from self._step(routine.owner, pair)

    def _step(self, owner: str, pair: Pairing) -> Iterator[Difference]:
        old, new = pair.old, pair.new
        if old is None or new is None:
            yield _difference(REMOVED if new is None else ADDED, owner, old, new)
            return
        if pair.moved and new.what == ELEMENT:
            self._note(ORDER, f"elements of {owner}")
        elif pair.moved:
            yield _difference(MOVED, owner, old, new)
        elif old.key != new.key:
            yield _difference(CHANGED, owner, old, new)
        elif old.layout != new.layout:
            self._note(LAYOUT, owner)
        if old.comment != new.comment:
            rung_name = _name_of(new)
            yield Difference(
                CHANGED, "comment", owner, rung_name, new.line, old.comment, new.comment, "", (old,), (new,)
            )

    def _note(self, what: str, where: str) -> None:
        if where not in self._apart[what]:
            self._apart[what].append(where)

    def apart_lines(self) -> Iterator[str]:
        """Yield a line for each kind of change that is listed apart."""
        yield from (f"{noun} {', '.join(places)}" for noun, places in self._apart.items())


def _by_place(parts: Sequence[Item | CommonPart]) -> dict[int, Item]:
    return {place: part for place, part in enumerate(parts) if isinstance(part, Item)}


def _same_key(ours: Mapping[int, Item], theirs: Mapping[int, Item]) -> dict[int, int]:
    """Map new places to old ones: items with the same kind and name are paired in order."""
    by_key: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
    for i in sorted(ours, reverse=True):
        by_key[ours[i].key].append(i)
    return {k: by_key[item.key].pop() for k, item in theirs.items() if by_key[item.key]}


def _without_shared(
    old: Sequence[Item | CommonPart], new: Sequence[Item | CommonPart]
) -> tuple[list[Item | CommonPart], list[Item | CommonPart], dict[int, int]]:
    """Open common parts that one list lacks; return both lists, and old places of shared parts by new."""
    counts = Counter(part.content for part in old if isinstance(part, CommonPart)) & Counter(
        part.content for part in new if isinstance(part, CommonPart)
    )
    before, after = _opened(old, counts.copy()), _opened(new, counts)
    places: defaultdict[bytes, list[int]] = defaultdict(list)
    for i in range(len(before) - 1, -1, -1):
        part = before[i]
        if isinstance(part, CommonPart):
            places[part.content].append(i)
    return (
        before,
        after,
        {k: places[part.content].pop() for k, part in enumerate(after) if isinstance(part, CommonPart)},
    )


def _opened(items: Sequence[Item | CommonPart], counts: Counter[bytes]) -> list[Item | CommonPart]:
    """Replace each common part that the other list lacks with its items."""
    parts: list[Item | CommonPart] = []
    for part in items:
        if isinstance(part, Item):
            parts.append(part)
        elif counts[part.content] > 0:
            counts[part.content] -= 1
            parts.append(part)
        else:
            parts += part.open()
    return parts


def _same_content(
    ours: dict[int, Item], removed: Sequence[int], theirs: dict[int, Item], added: Sequence[int]
) -> dict[int, int]:
    """Map the place of each added item to the place of the only removed item with the same content."""
    if not removed or not added:
        return {}
    old, new = (_by_content(items, places) for items, places in ((ours, removed), (theirs, added)))
    return {
        new[content][0]: places[0]
        for content, places in old.items()
        if len(places) == 1 and len(new.get(content, ())) == 1
    }


def _by_content(items: dict[int, Item], places: Sequence[int]) -> dict[str, list[int]]:
    groups: defaultdict[str, list[int]] = defaultdict(list)
    for place in places:
        item = items[place]
        if item.what not in TAGS and (item.steps or item.items or item.what in ("data type", "module")):
            groups["\n".join(canonical_lines(replace(item, name="")))].append(place)
    return groups


def _different(old: Sequence[Field], new: Sequence[Field]) -> tuple[list[str], list[str]]:
    """Return the fields that only one version has."""
    if old == new:
        return [], []
    before, after = Counter(old), Counter(new)
    return list(map(" = ".join, before - after)), list(map(" = ".join, after - before))


def _orders_of_members(old: Item, new: Item) -> list[str]:
    """Return the orders that both versions have of their common members; [] if they have the same order.

    The order decides the layout of a type in memory.
    """
    if old.what != "data type":
        return []
    orders = _members(old), _members(new)
    common_labels = set(orders[0]).intersection(orders[1])
    before, after = (", ".join(label for label in order if label in common_labels) for order in orders)
    return [before, after] if before != after else []


def _members(item: Item) -> list[str]:
    labels = (label.removeprefix("member ") for label, _ in item.fields if label.startswith("member "))
    return [label for label in labels if "." not in label]


def _name(item: Item | CommonPart) -> str:
    return ", ".join(part.name for part in item.open()) if isinstance(item, CommonPart) else item.name


def _one(each: _One, names: dict[str, Item]) -> Iterator[Difference]:
    """Yield the difference of an item; for both names of a renamed tag only one, with its changed fields."""
    item = each.item
    if each.kind == REMOVED and item.what in TAGS and (new := names.get(item.name.upper())) is not None:
        before, after = _different(item.fields, new.fields)
        texts = "\n".join(before), "\n".join(after)
        yield Difference(RENAMED, item.what, each.owner, new.name, new.line, *texts, item.name)
        return
    if each.kind == ADDED and item.what in TAGS and any(item is new for new in names.values()):
        return
    text, steps = _text_of(item, steps=True), _all_steps(item)
    head = _text_of(item, steps=False)
    difference = Difference(each.kind, item.what, each.owner, item.name, item.line, "", "", head=head)
    removed = each.kind == REMOVED
    yield (
        replace(difference, before=text, old=steps) if removed else replace(difference, after=text, new=steps)
    )


def _text_of(item: Item, *, steps: bool) -> str:
    inner_lines = (line for part in item.opened() for line in canonical_lines(part, steps=steps))
    return "\n".join((*item.lines(steps=steps), *inner_lines))


def _all_steps(item: Item) -> tuple[Step, ...]:
    return (*item.steps, *(step for part in item.opened() for step in _all_steps(part)))


def _name_of(step: Step) -> str:
    return "" if step.what == ELEMENT else f"{step.what} {step.number}"


def _difference(kind: str, owner: str, old: Step | None, new: Step | None) -> Difference:
    step = new or old
    assert step is not None
    before, after = ("" if side is None else side.text for side in (old, new))
    olds, news = (() if side is None else (side,) for side in (old, new))
    old_name = _name_of(old) if kind == MOVED and old is not None and old.number != step.number else ""
    name = _name_of(step)
    return Difference(kind, step.what, owner, name, step.line, before, after, old_name, olds, news)
