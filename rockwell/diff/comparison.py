"""The differences of two outlines.

| kind | difference |
|---|---|
| added, removed | an item or a step that only one version has |
| changed | fields of an item; a step with a similar text; a comment |
| moved | a rung or line at a different place in the order of execution |
| renamed | an item with the same content, a tag with the same uses |

The order of named items, dates, authors, white space and positions on a sheet are listed separately, since
they do not affect execution.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from .alignment import Pair, longest_chain
from .outline import ELEMENT, CommonPart, Field, Item, Step, canonical_lines, path_of
from .pairing import Pairing, paired, without_renamed_ends
from .renames import TAGS, renamed, with_new_names

ADDED, REMOVED, CHANGED, MOVED, RENAMED = "added", "removed", "changed", "moved", "renamed"

MOST_LINES = 100
"""Maximum number of printed lines of a difference."""

ORDERED = frozenset({"parameter"})
"""Items whose order determines the order of a call's operands."""

ORDER, DATES, LAYOUT = (
    "the order of",
    "dates, authors and options of",
    "blanks and places on the sheet of",
)
"""Changes that are listed separately from the differences."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two versions."""

    kind: str  # `ADDED`, `REMOVED`, `CHANGED`, `MOVED` or `RENAMED`
    noun: (
        str  # "rung", "line", "element", "comment", or the noun of an item: "tag", "routine", "data type", …
    )
    owner: str  # program or add-on, and routine; "" for the controller
    name: str  # the name of an item, or "rung 3"
    line: int  # in the new file; for a removal, in the old file
    old_text: str  # "" for additions
    new_text: str  # "" for removals
    old_name: str = ""  # the old name of a renamed item, or of a moved step if its number differs
    old_steps: tuple[Step, ...] = ()  # the steps that are drawn
    new_steps: tuple[Step, ...] = ()
    fields_text: str = ""  # the text of an added or removed item without its steps

    @property
    def place(self) -> str:
        """Its owner and its name, as text."""
        return ", ".join(filter(None, (self.owner, self.name)))

    @property
    def heading(self) -> str:
        """The difference without its texts, on one line."""
        if self.noun == "comment":
            subject = f"comment of {self.name}"
        elif self.name.startswith(f"{self.noun} "):
            subject = self.name
        else:
            subject = " ".join(filter(None, (self.noun, self.name)))
        old_name = f", was {self.old_name}" if self.old_name else ""
        return f"{subject} {self.kind}{old_name} (line {self.line})"

    def lines(self) -> Iterator[str]:
        """Yield the difference as lines of text."""
        yield self.heading
        if self.kind == MOVED:
            yield from _first_lines("    ", self.new_text)
            return
        yield from _first_lines("  - ", self.old_text)
        yield from _first_lines("  + ", self.new_text)

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {
            "kind": self.kind,
            "what": self.noun,
            "where": self.place,
            "line": self.line,
            "was": self.old_name,
            "before": self.old_text,
            "after": self.new_text,
        }


def _first_lines(mark: str, text: str) -> Iterator[str]:
    """Yield the first lines of a text, each after a mark."""
    lines = text.splitlines()
    yield from (f"{mark}{line}" for line in lines[:MOST_LINES])
    if len(lines) > MOST_LINES:
        yield f"{mark}… {len(lines) - MOST_LINES:,} more lines"


@dataclass(frozen=True, slots=True)
class Comparison:
    """All differences between two versions, and the changes that are listed separately."""

    differences: tuple[Difference, ...]
    apart: tuple[str, ...]

    def lines(self) -> Iterator[str]:
        """Yield the comparison as lines of text, grouped by program and routine."""
        for owner, differences in self.by_owner().items():
            indent = ""
            if owner:
                yield owner
                indent = "  "
            for difference in differences:
                yield from (f"{indent}{line}" for line in difference.lines())
        yield self.summary
        yield from (f"not counted: {note}" for note in self.apart)

    def as_json(self) -> dict[str, Any]:
        """Return the data for `--json`."""
        return {
            "differences": [difference.as_json() for difference in self.differences],
            "apart": list(self.apart),
        }

    def by_owner(self) -> dict[str, list[Difference]]:
        """Return the differences by program and routine, with the controller's differences first."""
        groups: defaultdict[str, list[Difference]] = defaultdict(list)
        for difference in sorted(self.differences, key=lambda difference: bool(difference.owner)):
            groups[difference.owner].append(difference)
        return dict(groups)

    @property
    def summary(self) -> str:
        """The differences on one line, such as `3 differences: 1 tag added, 2 rungs changed`."""
        counts = Counter((difference.noun, difference.kind) for difference in self.differences)
        phrases = [f"{count} {_plural(noun, count)} {kind}" for (noun, kind), count in counts.items()]
        total = len(self.differences)
        return f"{total:,} {_plural('difference', total)}: {', '.join(phrases)}" if total else "no difference"


def _plural(noun: str, count: int) -> str:
    return f"{noun}s" if count > 1 else noun


def compared(old: Item, new: Item) -> Comparison:
    """Compare two outlines."""
    comparer = _Comparer()
    comparer.item(old, new, "")
    return Comparison(tuple(comparer.differences()), tuple(comparer.apart_lines()))


@dataclass(slots=True)
class _Scope:
    """The items and steps of a program, add-on or controller that may show which tags were renamed."""

    removed: list[Item] = field(default_factory=list)
    added: list[Item] = field(default_factory=list)
    old_steps: list[Step] = field(default_factory=list)
    new_steps: list[Step] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Routine:
    """A pair of routines; their steps are compared after tags, because tags may be renamed."""

    path: str
    old: Item
    new: Item


@dataclass(frozen=True, slots=True)
class _SingleItem:
    """An item that only one version has."""

    owner: str
    kind: str  # `ADDED` or `REMOVED`
    item: Item


class _Comparer:
    """Compares items first, then tags by their uses, then steps."""

    def __init__(self) -> None:
        self._entries: list[Difference | _Routine | _SingleItem] = []  # in the order of the new version
        self._scopes: defaultdict[str, _Scope] = defaultdict(_Scope)
        self._apart: defaultdict[str, list[str]] = defaultdict(list)

    # --- items

    def item(self, old: Item, new: Item, owner: str) -> None:
        """Compare two items with the same name."""
        path = path_of(owner, new)
        self._compare_fields(old, new, owner)
        if old.dates != new.dates:
            self._apart[DATES].append(path or f"the {new.noun}".replace("export", "file"))
        if old.steps or new.steps:
            self._entries.append(_Routine(path, old, new))
            for scope in {"", owner}:
                self._scopes[scope].old_steps += old.steps
                self._scopes[scope].new_steps += new.steps
        self._compare_items(old.items, new.items, path)

    def _compare_fields(self, old: Item, new: Item, owner: str) -> None:
        """Report changed fields, or else changed details, and a changed member order of a data type."""
        old_fields, new_fields = _changed_fields(old.fields, new.fields)
        if not old_fields and not new_fields:
            old_fields, new_fields = _changed_fields(old.details, new.details)
        if old.noun == "data type":  # the order of members decides their places in memory
            old_order, new_order = _orders_of_members(old, new)
            if old_order != new_order:
                old_fields.append(f"order of members = {old_order}")
                new_fields.append(f"order of members = {new_order}")
        if old_fields or new_fields:
            old_text, new_text = "\n".join(old_fields), "\n".join(new_fields)
            self._entries.append(Difference(CHANGED, new.noun, owner, new.name, new.line, old_text, new_text))

    def _compare_items(
        self, old: Sequence[Item | CommonPart], new: Sequence[Item | CommonPart], path: str
    ) -> None:
        """Compare the inner items of the item at a path."""
        old, new = _with_same_parts(old, new)
        old_items, new_items = _only_items(old), _only_items(new)
        pairs = _pairs_by_key(old_items, new_items)
        added = [k for k in new_items if k not in pairs]
        removed = sorted(old_items.keys() - pairs.values())
        for k, i in _pairs_by_content(old_items, removed, new_items, added).items():
            pairs[k] = i
            removed.remove(i)
            item, old_name = new_items[k], old_items[i].name
            place = (item.noun, path, item.name, item.line)
            self._entries.append(Difference(RENAMED, *place, old_text="", new_text="", old_name=old_name))
        self._compare_orders(new, pairs | _pairs_of_parts(old, new), path)
        for i in removed:
            self._add_unpaired(path, REMOVED, old_items[i])
        for k, item in new_items.items():
            if k not in pairs:
                self._add_unpaired(path, ADDED, item)
            elif item.name.upper() == old_items[pairs[k]].name.upper():
                self.item(old_items[pairs[k]], item, path)

    def _add_unpaired(self, owner: str, kind: str, item: Item) -> None:
        self._entries.append(_SingleItem(owner, kind, item))
        scope = self._scopes[owner]
        (scope.removed if kind == REMOVED else scope.added).append(item)

    def _compare_orders(self, new: Sequence[Item | CommonPart], pairs: Mapping[int, int], path: str) -> None:
        """Note each kind of item whose pairs are in a different order; report the kinds whose order matters.

        Args:
            pairs: old indexes by new index.
        """
        by_noun: defaultdict[str, list[Pair]] = defaultdict(list)  # here the new index comes first
        for k in sorted(pairs):
            by_noun[new[k].noun].append((k, pairs[k]))
        for noun, noun_pairs in by_noun.items():
            if len(longest_chain(noun_pairs)) == len(noun_pairs):
                continue
            if noun in ORDERED:
                new_order = [k for k, _ in noun_pairs]
                old_order = sorted(new_order, key=pairs.__getitem__)
                old_text, new_text = (
                    f"order of {noun}s = {', '.join(_names(new[k]) for k in order)}"
                    for order in (old_order, new_order)
                )
                line = new[new_order[0]].line
                self._entries.append(Difference(CHANGED, "add-on", "", path, line, old_text, new_text))
            else:
                self._apart[ORDER].append(f"{noun}s of {path}" if path else f"{noun}s")

    # --- tags, then steps

    def differences(self) -> Iterator[Difference]:
        """Yield the differences in the order of the new version."""
        new_tags = {
            owner: renamed(scope.removed, scope.added, scope.old_steps, scope.new_steps)
            for owner, scope in self._scopes.items()
        }
        for entry in self._entries:
            if isinstance(entry, Difference):
                yield entry
            elif isinstance(entry, _SingleItem):
                yield from _unpaired_differences(entry, new_tags.get(entry.owner, {}))
            else:
                # the tags of the routine's program hide the controller's
                program = entry.path.rpartition(", ")[0]
                yield from self._compare_steps(entry, {**new_tags.get("", {}), **new_tags.get(program, {})})

    def _compare_steps(self, routine: _Routine, new_tags: dict[str, Item]) -> Iterator[Difference]:
        """Yield the differences of two routines' steps, with the new names of tags in the old steps."""
        old_steps = [with_new_names(step, new_tags) for step in routine.old.steps]
        for pair in without_renamed_ends(paired(old_steps, routine.new.steps)):
            yield from self._compare_pair(routine.path, pair)

    def _compare_pair(self, owner: str, pair: Pairing) -> Iterator[Difference]:
        """Yield the differences of a pair of steps; record changes that are listed separately."""
        old, new = pair.old, pair.new
        if old is None or new is None:
            yield _step_difference(REMOVED if new is None else ADDED, owner, old, new)
            return
        if pair.moved and new.noun == ELEMENT:
            self._note(ORDER, f"elements of {owner}")
        elif pair.moved:
            yield _step_difference(MOVED, owner, old, new)
        elif old.key != new.key:
            yield _step_difference(CHANGED, owner, old, new)
        elif old.layout != new.layout:
            self._note(LAYOUT, owner)
        if old.comment != new.comment:
            place = ("comment", owner, _name_of(new), new.line)
            texts = (old.comment, new.comment)
            yield Difference(CHANGED, *place, *texts, old_steps=(old,), new_steps=(new,))

    def _note(self, change: str, place: str) -> None:
        if place not in self._apart[change]:
            self._apart[change].append(place)

    def apart_lines(self) -> Iterator[str]:
        """Yield a line for each kind of change that is listed separately."""
        yield from (f"{change} {', '.join(places)}" for change, places in self._apart.items())


def _with_same_parts(
    old: Sequence[Item | CommonPart], new: Sequence[Item | CommonPart]
) -> tuple[list[Item | CommonPart], list[Item | CommonPart]]:
    """Return both lists; common parts that the other list lacks are replaced by their items."""
    old_counts, new_counts = (
        Counter(part.content for part in parts if isinstance(part, CommonPart)) for parts in (old, new)
    )
    counts = old_counts & new_counts
    return _opened(old, counts.copy()), _opened(new, counts)


def _opened(parts: Sequence[Item | CommonPart], counts: Counter[bytes]) -> list[Item | CommonPart]:
    """Replace common parts by their items, except the first `counts` parts with each content."""
    opened: list[Item | CommonPart] = []
    for part in parts:
        if isinstance(part, Item):
            opened.append(part)
        elif counts[part.content] > 0:
            counts[part.content] -= 1
            opened.append(part)
        else:
            opened += part.open()
    return opened


def _only_items(parts: Sequence[Item | CommonPart]) -> dict[int, Item]:
    """Return the items in a list by index."""
    return {index: part for index, part in enumerate(parts) if isinstance(part, Item)}


def _pairs_of_parts(old: Sequence[Item | CommonPart], new: Sequence[Item | CommonPart]) -> dict[int, int]:
    """Return the old indexes of common parts by new index; parts with equal content pair up in order."""
    old_indexes: defaultdict[bytes, deque[int]] = defaultdict(deque)
    for i, part in enumerate(old):
        if isinstance(part, CommonPart):
            old_indexes[part.content].append(i)
    return {
        k: old_indexes[part.content].popleft() for k, part in enumerate(new) if isinstance(part, CommonPart)
    }


def _pairs_by_key(old: Mapping[int, Item], new: Mapping[int, Item]) -> dict[int, int]:
    """Return the old indexes of items with the same noun and name by new index, repeated ones in order."""
    old_indexes: defaultdict[tuple[str, str], deque[int]] = defaultdict(deque)
    for i, item in old.items():
        old_indexes[item.key].append(i)
    return {k: old_indexes[item.key].popleft() for k, item in new.items() if old_indexes[item.key]}


def _pairs_by_content(
    old: dict[int, Item], removed: Sequence[int], new: dict[int, Item], added: Sequence[int]
) -> dict[int, int]:
    """Return the old indexes, by new index, of added items whose content only one removed item has."""
    if not removed or not added:
        return {}
    old_indexes, new_indexes = _by_content(old, removed), _by_content(new, added)
    pairs = {}
    for content, matches in old_indexes.items():
        new_matches = new_indexes.get(content, [])
        if len(matches) == len(new_matches) == 1:
            pairs[new_matches[0]] = matches[0]
    return pairs


def _by_content(items: dict[int, Item], indexes: Sequence[int]) -> dict[str, list[int]]:
    """Return the indexes of items by their text; tags and items with little content are omitted."""
    groups: defaultdict[str, list[int]] = defaultdict(list)
    for index in indexes:
        item = items[index]
        if item.noun not in TAGS and (item.steps or item.items or item.noun in ("data type", "module")):
            groups["\n".join(canonical_lines(replace(item, name="")))].append(index)
    return groups


def _changed_fields(old: Sequence[Field], new: Sequence[Field]) -> tuple[list[str], list[str]]:
    """Return the fields that only the old or only the new version has, as lines."""
    if old == new:
        return [], []
    old_counts, new_counts = Counter(old), Counter(new)
    return list(map(" = ".join, old_counts - new_counts)), list(map(" = ".join, new_counts - old_counts))


def _orders_of_members(old: Item, new: Item) -> tuple[str, str]:
    """Return the old and the new order of the members that both versions of a data type have."""
    old_members, new_members = _members(old), _members(new)
    common = set(old_members).intersection(new_members)
    old_order, new_order = (
        ", ".join(member for member in members if member in common) for members in (old_members, new_members)
    )
    return old_order, new_order


def _members(item: Item) -> list[str]:
    """Return the members of a data type in order."""
    labels = (label.removeprefix("member ") for label, _ in item.fields if label.startswith("member "))
    return [label for label in labels if "." not in label]


def _names(part: Item | CommonPart) -> str:
    return ", ".join(item.name for item in part.open()) if isinstance(part, CommonPart) else part.name


def _unpaired_differences(entry: _SingleItem, new_tags: dict[str, Item]) -> Iterator[Difference]:
    """Yield the differences for an item that only one version has.

    A renamed tag has one difference, at the place of its old name.
    """
    item, owner = entry.item, entry.owner
    if item.noun in TAGS and entry.kind == REMOVED:
        tag = new_tags.get(item.name.upper())
        if tag is not None:
            old_text, new_text = map("\n".join, _changed_fields(item.fields, tag.fields))
            place = (item.noun, owner, tag.name, tag.line)
            yield Difference(RENAMED, *place, old_text, new_text, old_name=item.name)
            return
    elif item.noun in TAGS and any(item is tag for tag in new_tags.values()):
        return
    text, steps, fields_text = _text_of(item, steps=True), _all_steps(item), _text_of(item, steps=False)
    place = (item.noun, owner, item.name, item.line)
    if entry.kind == REMOVED:
        yield Difference(REMOVED, *place, text, "", old_steps=steps, fields_text=fields_text)
    else:
        yield Difference(ADDED, *place, "", text, new_steps=steps, fields_text=fields_text)


def _text_of(item: Item, *, steps: bool) -> str:
    """Return the lines of an item and of the items in it."""
    inner_lines = (line for inner in item.opened() for line in canonical_lines(inner, steps=steps))
    return "\n".join((*item.lines(steps=steps), *inner_lines))


def _all_steps(item: Item) -> tuple[Step, ...]:
    return (*item.steps, *(step for inner in item.opened() for step in _all_steps(inner)))


def _name_of(step: Step) -> str:
    return "" if step.noun == ELEMENT else f"{step.noun} {step.number}"


def _step_difference(kind: str, owner: str, old: Step | None, new: Step | None) -> Difference:
    """Return the difference of a step; a removed step has no new version, an added step no old one."""
    step = new or old
    assert step is not None
    has_new_number = kind == MOVED and old is not None and old.number != step.number
    return Difference(
        kind,
        step.noun,
        owner,
        _name_of(step),
        step.line,
        old_text="" if old is None else old.text,
        new_text="" if new is None else new.text,
        old_name=_name_of(old) if old is not None and has_new_number else "",
        old_steps=() if old is None else (old,),
        new_steps=() if new is None else (new,),
    )
