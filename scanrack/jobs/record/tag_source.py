"""Reads the tags of a run in every scan with one generated function.

    def take():
        return pack(images(), Fill_ACC, Run, *Recipe)

Variables of a ladder program are read from the cells of its memory; names of a Python program are looked up
in its module. The recording affects neither the compiler nor the program.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from struct import Struct
from types import CellType, CodeType, FunctionType
from typing import Any

from scanrack.io_images.tag_names import TEXT
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.tag_values import TagValue, TagValues, tag_values
from scanrack.ladder.lowering.runnable import LadderLogic
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.run.engine import Engine
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.format.tagplan import LAST_CODE, Tag, TagPlan, plan_of

from .tag_names import named_values, namespace_of

Pending = list[tuple[str, Mapping[str, str | int]]]


@dataclass(frozen=True, slots=True)
class RecordedTag:
    """A tag and the expression that reads it."""

    tag: Tag
    source: str  # the expression; for a TEXT, arguments of the function that returns its code
    codes: Mapping[Any, int] = field(default_factory=dict)  # codes of an ENUM, by value of the member


class TextCodes:
    """Numbers the texts of a run in order of first appearance."""

    def __init__(self, pending: Pending) -> None:
        self._codes: dict[str, int] = {}
        self.pending = pending  # messages of the last scan
        self._full = False

    def code(self, name: str, text: str) -> int:
        """Return the code of a tag's new text, and report the change."""
        code = self._codes.get(text)
        if code is None:
            if len(self._codes) >= LAST_CODE:
                return self._code_beyond_limit(name)
            code = self._codes[text] = len(self._codes)
        self.pending.append(("/texts", {"tag": name, "code": code, "text": text}))
        return code

    def _code_beyond_limit(self, name: str) -> int:
        """Return the common code of all texts beyond the limit; report this once."""
        if not self._full:
            self._full = True
            text = f"{name}: this is text {LAST_CODE + 1:,}; from here on new texts are recorded as one"
            self.pending.append(("/events", {"kind": "tag", "name": name, "text": text}))
        return LAST_CODE


class TextValue:
    """The code of one tag's text, which is looked up only when the text changes."""

    def __init__(self, name: str, codes: TextCodes) -> None:
        self._name, self._codes = name, codes
        self._last: object = None
        self._code = 0

    def of_text(self, text: str) -> int:
        """Return the code of a str."""
        if text != self._last:
            if not isinstance(text, str):
                raise TypeError(f"{type(text).__name__} is not text")
            writable = text.encode("utf-8", "replace").decode()  # a lone surrogate can't be encoded
            self._code, self._last = self._codes.code(self._name, writable), text
        return self._code

    def of_string(self, length: int, data: Sequence[int]) -> int:
        """Return the code of a ladder program's STRING."""
        characters = data[: max(0, length)]
        if characters != self._last:
            text = bytes(code & 0xFF for code in characters).decode("latin-1")
            self._code, self._last = self._codes.code(self._name, text), characters
        return self._code


class ProgramTags:
    """The tags of a program, for a recorder; see `traces.tagplan.TagSource`.

    Args:
        cells: variables of a ladder program.
        namespace: namespace of a Python program's module.
        texts: assigns numbers to texts; by default from 0.

    Attributes:
        pending: messages about the last scan.
        take: returns the memory block and tags.
    """

    def __init__(
        self,
        recorded: Sequence[RecordedTag],
        cells: Mapping[str, CellType],
        namespace: dict[str, Any],
        memory: bytearray,
        texts: TextCodes | None = None,
    ) -> None:
        """Generate `take`. If a value does not fit its type, `take` reads the tags one by one instead."""
        texts = texts or TextCodes([])
        self.texts = texts
        self.plan: TagPlan = plan_of([recorded_tag.tag for recorded_tag in recorded])
        self.pending: Pending = texts.pending
        self._images = memoryview(memory).tobytes
        self._refused: set[str] = set()
        by_name = {recorded_tag.tag.name: recorded_tag for recorded_tag in recorded}
        order = [by_name[field.tag.name] for field in self.plan.fields]
        variables, sources = _expressions(order, texts, in_cells=bool(cells))
        variables |= {"__pack": Struct(f"<{len(memory)}s{self.plan.letters}").pack, "__images": self._images}
        variables |= {"__one_by_one": self._take_one_by_one, "__error": Exception}
        call = f"__pack(__images(), {', '.join(sources)})"
        body = f"try:\n   return {call}\n  except __error:\n   return __one_by_one()"
        all_cells = {**cells, **{name: CellType(value) for name, value in variables.items()}}
        self.take: Callable[[], bytes] = _functions([body], all_cells, namespace)[0]
        self._sources, self._cells, self._namespace = sources, all_cells, namespace

    @cached_property
    def _readers(self) -> list[Callable[[], list[Any]]]:
        """Functions that each read one tag; compiled only when a value does not fit."""
        bodies = [f"return [{source}]" for source in self._sources]
        return _functions(bodies, self._cells, self._namespace)

    def _take_one_by_one(self) -> bytes:
        """Return images and tags; a value that does not fit becomes 0, with one event for each tag."""
        parts = [self._images()]
        for read, recorded_field in zip(self._readers, self.plan.fields, strict=True):
            form = Struct("<" + recorded_field.letters)
            try:
                parts.append(form.pack(*read()))
            except Exception as error:
                parts.append(bytes(form.size))
                self._refuse(recorded_field.tag, error)
        return b"".join(parts)

    def _refuse(self, tag: Tag, error: Exception) -> None:
        """Report, once for each tag, that its value does not fit and is recorded as 0."""
        if tag.name in self._refused:
            return
        self._refused.add(tag.name)
        reason = str(error) if isinstance(error, struct.error) else f"{type(error).__name__}: {error}"
        text = f"{tag.name} has no value that fits {tag.type} ({reason}): it is recorded as 0"
        self.pending.append(("/events", {"kind": "tag", "name": tag.name, "text": text}))


class WatchedTags:
    """The tags of a program under a debugger. The program can be edited while it runs.

    After an edit, a tag is 0 if the edit has dropped it or changed its type.

    Args:
        patterns: see `ladder.tag_values`.

    Attributes:
        pending: messages of the last scan.
    """

    def __init__(self, debugger: Debugger, patterns: Sequence[str], memory: bytearray) -> None:
        self._debugger, self._memory = debugger, memory
        self._engine: Engine = debugger.engine
        self._tags = ProgramTags(_ladder_tags(self._engine, patterns), self._engine.memory.cells, {}, memory)
        self.plan, self.pending = self._tags.plan, self._tags.pending

    def take(self) -> bytes:
        """Return the current memory block and tags."""
        if self._debugger.engine is not self._engine:
            self._read_from(self._debugger.engine)
        return self._tags.take()

    def _read_from(self, engine: Engine) -> None:
        """Read the tags from an engine, such as the engine of an edited program."""
        self._engine = engine
        values = TagValues(engine.lowered.layout)
        recorded = [_after_edit(values, field.tag) for field in self.plan.fields]
        self._tags = ProgramTags(recorded, engine.memory.cells, {}, self._memory, self._tags.texts)


def _after_edit(values: TagValues, tag: Tag) -> RecordedTag:
    """Return a tag with its expression in an edited program."""
    try:
        matching = [match for match in map(_recorded_tag, values.matching(tag.name)) if match.tag == tag]
    except LadderError:
        matching = []
    zeros = "0, []" if tag.type == TEXT else f"*[0] * {tag.length}" if tag.length else "0"
    return matching[0] if matching else RecordedTag(tag, zeros)


def _ladder_tags(engine: Engine, patterns: Sequence[str]) -> list[RecordedTag]:
    return [_recorded_tag(tag_value) for tag_value in tag_values(engine.lowered.layout, patterns)]


def _recorded_tag(value: TagValue) -> RecordedTag:
    return RecordedTag(Tag(value.name, value.type, value.length), value.source)


def tags_of(logic: ScanLogic, patterns: Sequence[str], memory: bytearray) -> ProgramTags | WatchedTags:
    """Return the tags of a program that match patterns.

    Args:
        patterns: see `ladder.tag_values` and `tag_names`.

    Raises:
        ValueError: a pattern matches nothing, or the tags exceed the limit of a scan.
    """
    if isinstance(logic, Debugger):
        return WatchedTags(logic, patterns, memory)
    if isinstance(logic, LadderLogic | Engine):
        engine = logic.engine if isinstance(logic, LadderLogic) else logic
        return ProgramTags(_ladder_tags(engine, patterns), engine.memory.cells, {}, memory)
    namespace = namespace_of(logic)
    recorded = []
    for named_value in named_values(namespace, patterns):
        names = tuple(member.name for member in named_value.members)
        codes = {member.value: code for code, member in enumerate(named_value.members)}
        recorded.append(
            RecordedTag(Tag(named_value.name, named_value.type, names=names), named_value.source, codes)
        )
    return ProgramTags(recorded, {}, namespace, memory)


def _expressions(
    recorded: Sequence[RecordedTag], texts: TextCodes, *, in_cells: bool
) -> tuple[dict[str, object], list[str]]:
    """Return the expressions that read tags, and the variables in them, by name."""
    variables: dict[str, object] = {}
    sources = []
    for number, recorded_tag in enumerate(recorded):
        name = f"__value{number}"
        if recorded_tag.tag.type == TEXT:
            value = TextValue(recorded_tag.tag.name, texts)
            variables[name] = value.of_string if in_cells else value.of_text
            sources.append(f"{name}({recorded_tag.source})")
        elif recorded_tag.tag.type == "ENUM":
            variables[name] = recorded_tag.codes
            sources.append(f"{name}[{recorded_tag.source}._value_]")
        else:
            sources.append(recorded_tag.source)
    return variables, sources


def _functions(
    bodies: Sequence[str], cells: Mapping[str, CellType], namespace: dict[str, Any]
) -> list[Callable[[], Any]]:
    """Compile functions without arguments; `cells` are their free variables, `namespace` their globals.

    They share one outer function with all cells, so that compiling a function takes only as long as compiling
    its body.
    """
    inner = "".join(f" def take():\n  {body}\n" for body in bodies)
    outer = _code_in(compile(f"def outer({', '.join(cells)}):\n{inner}", "<tags>", "exec"))[0]
    return [
        FunctionType(code, namespace, "take", None, tuple(cells[name] for name in code.co_freevars))
        for code in _code_in(outer)
    ]


def _code_in(code: CodeType) -> list[CodeType]:
    return [constant for constant in code.co_consts if isinstance(constant, CodeType)]
