"""Values that a program keeps through an online edit, or until its next run (retentive).

An edit happens between two scans. As in a controller, the edited program is not prescanned and continues with
the next scan.

A file of retained tags is JSON: the program's name, and each tag's type and its value in the form of `Tags`.
Reading the file executes no code.
"""

from __future__ import annotations

import json
from collections.abc import Container, Iterable, Iterator
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.io_images.text_limits import TextKind
from scanrack.io_images.times import seconds

from ..model.errors import LadderError
from ..model.schedule import Schedule
from ..model.tags import Layout, Leaf, Tag, tag_in
from ..model.types import HIDDEN, dims_text
from ..state.lowered import LoweredProgram
from .engine import Engine

NUMBERS = ("~axis", "~number")
"""Hidden members that number the axes and motion instructions, in an order that depends on the program."""

FORMAT = "scanrack tags 1"
"""Format entry of a file of retained tags."""


@dataclass(frozen=True, slots=True)
class Edit:
    """The tags after an online edit."""

    now_ns: int  # virtual time of the previous scan
    kept: tuple[str, ...]  # tags with their old values
    new: tuple[str, ...]  # new tags, with initial values
    changed: tuple[str, ...]  # tags with a new type, with initial values
    dropped: tuple[str, ...]  # removed tags
    restated: tuple[str, ...] = ()  # kept values that differ from the program text: `Fill.PRE 1000, not 2000`

    @property
    def keeps(self) -> str:
        """Text with the number of tags that keep their values."""
        return f"{len(self.kept)} tags keep their values"

    @property
    def groups(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The tags that the edit affects, grouped by effect."""
        return (
            ("new", self.new),
            ("of another type", self.changed),
            ("gone", self.dropped),
            ("keep their value", self.restated),
        )

    def __str__(self) -> str:
        parts = [f"{title}: {', '.join(names)}" for title, names in self.groups if names]
        return "; ".join([f"edited at {seconds(self.now_ns)} s, {self.keeps}", *parts])


def carry_over(old: Engine, new: Engine) -> Edit:
    """Continue in a fresh engine from the state of another engine, which does not change."""
    edit, old_layout = planned(old, new.lowered), old.lowered.layout
    kept = _kept_leaves(old_layout, new.lowered.layout)
    for leaf in kept:
        if leaf.path.endswith(NUMBERS):
            continue
        source = old_layout.leaves[leaf.path.upper()]
        for index in range(leaf.size):
            new.memory.write(leaf, index, old.memory.read(source, index))
    if new.lowered.ideal is not None and old.lowered.ideal is not None:
        new.lowered.ideal.renumber_motions(old.lowered.ideal, new.memory)
    new.continue_from(old)
    if new.lowered.schedule is not None:
        _schedule_new_tasks(new, new.lowered.schedule, {leaf.path for leaf in kept})
    return edit


def planned(old: Engine, new: LoweredProgram) -> Edit:
    """Return the effects of an edit without making it."""
    leaves = _kept_leaves(old.lowered.layout, new.layout)
    kept_paths = {leaf.path.upper() for leaf in leaves}
    old_tags, new_tags = old.lowered.layout.tags(), new.layout.tags()
    incomplete = {tag_in(path) for path in new.layout.leaves if path not in kept_paths}
    kept, fresh, changed = list[str](), list[str](), list[str]()
    for name, tag in new_tags.items():
        if name not in old_tags:
            fresh.append(tag.name)
        else:
            (changed if name in incomplete else kept).append(tag.name)
    dropped = (tag.name for name, tag in old_tags.items() if name not in new_tags)
    restated = tuple(_restated(old, new, leaves))
    return Edit(
        old.now_ns,
        kept=tuple(kept),
        new=tuple(fresh),
        changed=tuple(changed),
        dropped=tuple(dropped),
        restated=restated,
    )


def _kept_leaves(old: Layout, new: Layout) -> list[Leaf]:
    """Return the leaves of an edited program that keep their values."""
    return [leaf for leaf in new.leaves.values() if _is_same(leaf, old.leaves.get(leaf.path.upper()))]


def _restated(old: Engine, new: LoweredProgram, kept: Iterable[Leaf]) -> Iterator[str]:
    """Yield the kept values that differ from the new program text, as in `Fill.PRE 1000, not 2000`."""
    kept_paths = {leaf.path.upper() for leaf in kept}
    for (path, index), value in new.presets.items():
        if path.upper() not in kept_paths or old.lowered.presets.get((path, index), value) == value:
            continue
        present = old.memory.read(old.lowered.layout.leaves[path.upper()], index)
        if present != value and not path.startswith(HIDDEN):
            yield f"{path} {present}, not {value}"
    yield from _restated_initials(old, new, kept_paths)


def _restated_initials(old: Engine, new: LoweredProgram, kept_paths: Container[str]) -> Iterator[str]:
    """Yield the kept tags whose initial value was edited and differs from their value."""
    tags = old.lowered.layout.tags()
    for name, tag in new.layout.tags().items():
        if name in kept_paths and not tag.dims and tag.initial not in (None, tags[name].initial):
            present = old.tags[tag.name]
            if present != tag.initial:
                yield f"{tag.name} {present}, not {tag.initial}"


def _is_same(leaf: Leaf, other: Leaf | None) -> bool:
    """Return whether a leaf has the same type and size as the leaf with the same path in the old program."""
    if other is None or leaf.is_image:
        return False
    return (leaf.type, leaf.dims, leaf.slot) == (other.type, other.dims, other.slot)


def _schedule_new_tasks(engine: Engine, schedule: Schedule, kept: set[str]) -> None:
    """Make new periodic tasks due at the next multiple of their rate."""
    for task in schedule.tasks:
        rate = task.task.rate_ns
        if rate and task.due.path not in kept:
            engine.memory.write(task.due, 0, (engine.now_ns // rate + 1) * rate)


# --- retentive memory


def is_retained(layout: Layout, leaf: Leaf) -> bool:
    """Return whether a value is retained: it is part of a tag, and neither an image nor hidden."""
    return leaf.slot is None and HIDDEN not in leaf.path and tag_in(leaf.path).upper() in layout.tags()


def started_again(old: Engine, new: Engine) -> Engine:
    """Copy the values of tags and inputs to a fresh engine of the program, and return it."""
    layout = new.lowered.layout
    for leaf in layout.leaves.values():
        if is_retained(layout, leaf) or (leaf.is_input and new.memory.has(leaf)):
            for index in range(leaf.size):
                new.memory.write(leaf, index, old.memory.read(leaf, index))
    return new


def retained_text(engine: Engine) -> str:
    """Return the values of all tags as the text of a file, see `retain`."""
    tags = {
        tag.name: [type_text(tag), engine.tags[tag.name]] for tag in engine.lowered.layout.tags().values()
    }
    head = {"format": FORMAT, "program": engine.lowered.name}
    lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(entry)}" for name, entry in tags.items())
    return f'{json.dumps(head)[:-1]}, "tags": {{\n{lines}\n}}}}\n'


def retain(engine: Engine, text: str) -> list[str]:
    """Load retained tags into a fresh engine.

    Returns:
        A sentence for each rejected value.

    Raises:
        LadderError: the text is not a file of retained tags.
    """
    stored = _stored(text)
    tags = {tag.name.upper(): tag for tag in engine.lowered.layout.tags().values()}
    sentences = [f"{name} is no longer a tag of the program" for name in stored if name.upper() not in tags]
    stored_by_key = {name.upper(): entry for name, entry in stored.items()}
    for name, tag in tags.items():
        if name not in stored_by_key:
            sentences.append(f"{tag.name} is not in the file")
        else:
            sentences += _restore(engine, tag, *stored_by_key[name])
    return sentences


def _restore(engine: Engine, tag: Tag, kind: str, value: Any) -> list[str]:
    """Set a tag; if the value does not fit, return a sentence and leave the tag unchanged."""
    if kind != type_text(tag):
        return [f"{tag.name} is {type_text(tag)}, in the file {kind}"]
    initial = engine.tags[tag.name]
    try:
        engine.tags[tag.name] = value
    except ValueError as error:
        engine.tags[tag.name] = initial
        return [str(error)]
    shortages = list(_shortages(tag.name, value, initial))
    if shortages:
        engine.tags[tag.name] = initial
    return shortages[:1]


def _shortages(name: str, stored: Any, present: Any) -> Iterator[str]:
    """Yield the places where a stored value has fewer elements or members than the tag."""
    if isinstance(stored, list) and isinstance(present, list):
        if len(stored) < len(present):
            yield f"{name} has {len(present)} elements, in the file {len(stored)}"
        for number, (stored_item, present_item) in enumerate(zip(stored, present, strict=False)):
            yield from _shortages(f"{name}[{number}]", stored_item, present_item)
    elif isinstance(stored, dict) and isinstance(present, dict):
        for key, present_item in present.items():
            if key not in stored:
                yield f"{name}.{key} is not in the file"
            else:
                yield from _shortages(f"{name}.{key}", stored[key], present_item)


def _stored(text: str) -> dict[str, list[Any]]:
    """Return the type and the value of each tag in a file; raise a LadderError for any other text."""
    try:
        data = json_value(text, TextKind.RETAINED)
    except ValueError as error:
        raise LadderError(f"this is not a file of retained tags: {error}") from None
    tags = data.get("tags") if isinstance(data, dict) and data.get("format") == FORMAT else None
    if not isinstance(tags, dict):
        raise LadderError(f"this is not a file of retained tags: it does not say {FORMAT!r}")
    for name, entry in tags.items():
        if not isinstance(entry, list) or len(entry) != 2 or not isinstance(entry[0], str):
            raise LadderError(f"tag {name}: {entry!r} is not a type and a value")
    return tags


def type_text(tag: Tag) -> str:
    """Return the type of a tag as in a declaration, such as `DINT[2,3]`."""
    return f"{tag.type.name}{dims_text(tag.dims)}"
