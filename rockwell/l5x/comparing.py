"""Comparison of two versions of an export: rung by rung, tag by tag.

    rungs, structured text    aligned as a text comparison aligns lines; a changed rung shows both texts
    tags, types, add-ons, modules, tasks, programs    by name; what is different is listed by field

Neither needs to run: refused parts are compared as well.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from difflib import SequenceMatcher
from typing import Any, TypeVar

from lxml import etree

from .xml.records import AddOnRecord, ElementRecord, L5xDocument, ProgramRecord, RoutineRecord, TagRecord

ADDED, REMOVED, CHANGED = "added", "removed", "changed"


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two versions."""

    kind: str  # "added", "removed" or "changed"
    what: (
        str  # "rung", "line", "routine", "tag", "data type", "add-on", "program", "module", "task", "element"
    )
    where: str  # program or add-on, routine, and name or number
    line: int  # its line in the new file, for removals in the old one
    before: str  # the old text, "" for additions
    after: str  # the new text, "" for removals

    def lines(self) -> Iterator[str]:
        """Yield the difference as lines of text."""
        yield f"{self.where}: {self.what} {self.kind} (line {self.line})"
        yield from (f"    - {each}" for each in self.before.splitlines())
        yield from (f"    + {each}" for each in self.after.splitlines())

    def as_json(self) -> dict[str, Any]:
        """Return it for `--json`."""
        return asdict(self)


def differences(old: L5xDocument, new: L5xDocument) -> list[Difference]:
    """Return the differences between two unreleased documents."""
    return [
        *_named("data type", "", old.data_types, new.data_types, _type_text),
        *_named("module", "", old.modules, new.modules, _module_text),
        *_add_ons(old.add_ons, new.add_ons),
        *_named("tag", "", old.tags, new.tags, _tag_text),
        *_programs(old.programs, new.programs),
        *_named("task", "", old.tasks, new.tasks, _task_text),
    ]


Record = TypeVar("Record")


def _by_name(records: Iterable[Any]) -> dict[str, Any]:
    """Return records by name in capitals, the first of each name."""
    found: dict[str, Any] = {}
    for each in records:
        found.setdefault(each.name.upper(), each)
    return found


def _named(
    what: str, owner: str, old: Iterable[Any], new: Iterable[Any], text: Callable[[Any], str]
) -> Iterator[Difference]:
    """Compare named records as texts."""
    before, after = _by_name(old), _by_name(new)
    for name, each in before.items():
        if name not in after:
            yield Difference(REMOVED, what, _place(owner, each.name), each.line, text(each), "")
    for name, each in after.items():
        if name not in before:
            yield Difference(ADDED, what, _place(owner, each.name), each.line, "", text(each))
        elif text(before[name]) != text(each):
            lines = _only_different(text(before[name]), text(each))
            yield Difference(CHANGED, what, _place(owner, each.name), each.line, *lines)


def _only_different(before: str, after: str) -> tuple[str, str]:
    """Return the lines that only one text has."""
    old, new = before.splitlines(), after.splitlines()
    return "\n".join(each for each in old if each not in new), "\n".join(
        each for each in new if each not in old
    )


def _place(*parts: str) -> str:
    return ", ".join(filter(None, parts))


# --- what has no rungs


def _kind(record: Any) -> str:
    dims = ",".join(map(str, record.dims))
    return f"{record.type}[{dims}]" if dims else str(record.type)


def _type_text(record: Any) -> str:
    members = [f"{each.name} : {_kind(each)}" + _bit(each) for each in record.members]
    return "\n".join([*filter(None, (record.family, record.comment)), *members])


def _bit(member: Any) -> str:
    return f" AT {member.target}.{member.bit}" if member.target else ""


def _tag_text(record: TagRecord) -> str:
    target = f" := {record.target}" if record.target else ""
    fields = [f"{record.name} : {record.kind} {_kind(record)}{target}", record.usage, record.comment]
    fields += [f"{operand}: {text}" for operand, text in record.comments]
    fields += [f"required: {record.required}"] if record.usage else []
    return "\n".join([*filter(None, fields), *_values(record)])


def _values(record: TagRecord) -> Iterator[str]:
    """Yield the values of a tag, one per line: the decorated ones if there are any."""
    data = next((each for each in record.data if each.form == "Decorated"), None)
    if data is None:
        yield from (" ".join("".join(each.element.itertext()).split()) for each in record.data)
        return
    for element in data.element.iter():
        value = element.get("Value")
        if value is not None:
            yield f"{_path(element, data)} = {value}"
        elif isinstance(element.tag, str) and (element.text or "").strip():
            yield f"{_path(element, data)} = {element.text.strip()}"


def _path(element: etree._Element, top: etree._Element) -> str:
    names = []
    here: Any = element
    while here is not None and here is not top:
        names.append(here.get("Name") or here.get("Index") or "")
        here = here.getparent()
    return ".".join(filter(None, reversed(names))).replace(".[", "[") or "value"


def _fields(*names: str) -> Callable[[Any], str]:
    return lambda record: "\n".join(f"{each}: {getattr(record, each)}" for each in names)


_module_text = _fields(
    *("catalog", "vendor", "type", "code", "parent", "address", "bus", "rpi_us", "inhibited")
)
_program_text = _fields("main", "fault", "disabled", "comment")
_task_fields = _fields("kind", "rate", "priority", "inhibited", "comment")


def _task_text(record: Any) -> str:
    return f"{_task_fields(record)}\nprograms: {', '.join(record.programs)}"


# --- what has routines


def _programs(old: Sequence[ProgramRecord], new: Sequence[ProgramRecord]) -> Iterator[Difference]:
    yield from _named("program", "", old, new, _program_text)
    for before, after in _pairs(old, new):
        yield from _named("tag", after.name, before.tags, after.tags, _tag_text)
        yield from _routines(after.name, before.routines, after.routines)


def _add_ons(old: Sequence[AddOnRecord], new: Sequence[AddOnRecord]) -> Iterator[Difference]:
    yield from _named("add-on", "", old, new, lambda each: each.comment)
    for before, after in _pairs(old, new):
        tags = (*before.parameters, *before.locals), (*after.parameters, *after.locals)
        yield from _named("tag", after.name, *tags, _tag_text)
        yield from _routines(after.name, before.routines, after.routines)


def _pairs(old: Iterable[Record], new: Iterable[Record]) -> Iterator[tuple[Record, Record]]:
    """Yield pairs of the same name."""
    before: Mapping[str, Record] = _by_name(old)
    for name, each in _by_name(new).items():
        if name in before:
            yield before[name], each


def _routines(owner: str, old: Sequence[RoutineRecord], new: Sequence[RoutineRecord]) -> Iterator[Difference]:
    yield from _named("routine", owner, old, new, lambda each: f"{each.kind}\n{each.comment}".rstrip())
    for before, after in _pairs(old, new):
        where = _place(owner, after.name)
        yield from _rungs(where, before, after)
        yield from _lines(where, before, after)
        yield from _elements(where, before, after)


def _rungs(where: str, old: RoutineRecord, new: RoutineRecord) -> Iterator[Difference]:
    before, after = list(map(_logic, old.rungs)), list(map(_logic, new.rungs))
    for tag, i, j, k, n in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if tag == "equal":
            yield from _comments(where, old.rungs[i:j], new.rungs[k:n])
            continue
        paired = min(j - i, n - k)
        for one, other in zip(old.rungs[i : i + paired], new.rungs[k : k + paired], strict=True):
            yield _rung(CHANGED, where, other, one.text, other.text)
        yield from (_rung(REMOVED, where, each, each.text, "") for each in old.rungs[i + paired : j])
        yield from (_rung(ADDED, where, each, "", each.text) for each in new.rungs[k + paired : n])


def _logic(rung: Any) -> tuple[str, str]:
    parts = re.split(r"('(?:[^'$]++|\$.)*+')", rung.text)
    return rung.kind, "".join(part if part.startswith("'") else "".join(part.split()) for part in parts)


def _rung(kind: str, where: str, rung: Any, before: str, after: str) -> Difference:
    return Difference(kind, "rung", f"{where}, rung {rung.number}", rung.line, before, after)


def _comments(where: str, old: Sequence[Any], new: Sequence[Any]) -> Iterator[Difference]:
    for before, after in zip(old, new, strict=True):
        if before.comment != after.comment:
            place = f"{where}, rung {after.number}"
            yield Difference(CHANGED, "comment", place, after.line, before.comment, after.comment)


_PLACES = frozenset(("X", "Y", "HideDesc", "DescX", "DescY", "DescWidth", "Show", "ShowActions", "Width"))
"""Attributes of a chart's elements that are of its picture only."""


def _elements(where: str, old: RoutineRecord, new: RoutineRecord) -> Iterator[Difference]:
    """Compare the elements of charts as lines, with their attributes; texts are compared as lines."""
    before, after = (list(_texts_of(each.chart)) for each in (old, new))
    ours, theirs = ([text for text, _ in each] for each in (before, after))
    for tag, i, j, k, n in SequenceMatcher(None, ours, theirs, autojunk=False).get_opcodes():
        if tag != "equal":
            kind = {"insert": ADDED, "delete": REMOVED, "replace": CHANGED}[tag]
            _, line = after[k] if k < n else before[i]
            yield Difference(kind, "element", where, line, "\n".join(ours[i:j]), "\n".join(theirs[k:n]))


def _texts_of(element: ElementRecord | None) -> Iterator[tuple[str, int]]:
    for each in element.children if element is not None else ():
        given = " ".join(f"{name}={value}" for name, value in each.attributes.items() if name not in _PLACES)
        if given and each.tag != "Line":
            yield f"{each.tag} {given}", each.line
        yield from _texts_of(each)


def _lines(where: str, old: RoutineRecord, new: RoutineRecord) -> Iterator[Difference]:
    before, after = ([text.strip() for text, _ in each.lines] for each in (old, new))
    for tag, i, j, k, n in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if tag == "equal":
            continue
        kind = {"insert": ADDED, "delete": REMOVED, "replace": CHANGED}[tag]
        _, line = new.lines[k] if k < n else old.lines[i]
        texts = ("\n".join(text for text, _ in each) for each in (old.lines[i:j], new.lines[k:n]))
        yield Difference(kind, "line", where, line, *texts)
