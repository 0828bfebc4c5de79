"""Recorded tags as signals: `tags.fill_acc`, an element `tags.counts.3`, a bit of a code `tags.step.FILL`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from ..tagplan import FIELD, FORMATS, TagField, TagPlan
from .signal import Array, Kind, Signal
from .stream import Block

CODES = ("ENUM", "TEXT")
"""Types whose values stand for names."""


def tag_signals(plan: TagPlan, texts: Mapping[int, str]) -> Iterator[Signal]:
    """Yield a signal for every value of a row.

    Args:
        plan: the tags of the trace.
        texts: what codes of texts stand for.
    """
    for field in plan.fields:
        names = code_names(field, texts)
        for element in range(field.tag.length) if field.tag.length else (None,):
            name = f"{FIELD}.{field.name}" if element is None else f"{FIELD}.{field.name}.{element}"
            title = field.tag.name if element is None else f"{field.tag.name}[{element}]"
            read = partial(_values, field.name, element)
            signed = FORMATS[field.tag.type].letter.islower()
            yield Signal(name, _kind(field), read, names, _bits(field), title, signed)


def code_names(field: TagField, texts: Mapping[int, str]) -> Mapping[int, str]:
    """Return what the codes of a field stand for."""
    if field.tag.type == "TEXT":
        return texts
    return dict(enumerate(field.constants))


def is_named(signal: Signal, pattern: str) -> bool:
    r"""Return whether a pattern means a tag: by its name in the trace, or by its full name or the last part.

    `*` and `?` are wildcards, brackets are subscripts; case does not matter. As in a rack file, a name
    means all members and elements below it.

    >>> signal = Signal("tags.main_fill_acc", Kind.NUMBER, lambda block: block.flags, title=r"\Main.Fill.ACC")
    >>> [is_named(signal, each) for each in ("tags.*", "main_fill*", r"\main.fill", "fill.acc", "ACC", "Fi")]
    [True, True, True, True, True, False]
    """
    if not signal.title:
        return False
    text = "".join({"*": ".*", "?": "."}.get(each, re.escape(each)) for each in pattern)
    begins = re.compile(rf"{text}(?:[.\[]|$)", re.IGNORECASE)
    field = signal.name.removeprefix(f"{FIELD}.")
    parts = [match.start() + 1 for match in re.finditer(r"\.", signal.title)]
    tails = [signal.title[start:] for start in (0, *parts)]
    return any(begins.match(name) for name in (signal.name, field, *tails))


def constant(signal: Signal, name: str) -> Signal | None:
    """Return the condition that a code stands for a name; None where no code does."""
    codes = [code for code, known in signal.names.items() if known == name]
    if signal.kind is not Kind.CODE or not codes:
        return None
    return Signal(f"{signal.name}.{name}", Kind.BIT, partial(_is_code, signal, codes[0]))


def short_names(plan: TagPlan) -> Mapping[str, str]:
    r"""Return names that a user may write instead, in lower case, with the signals they mean.

    These are the field, the full name and its last part, where only one tag has it.

    >>> from ..tagplan import Tag, plan_of
    >>> short_names(plan_of([Tag(r"\Main.Lamp", "BOOL")]))
    {'main_lamp': 'tags.main_lamp', '\\main.lamp': 'tags.main_lamp', 'lamp': 'tags.main_lamp'}
    """
    meant: dict[str, set[str]] = {}
    for field in plan.fields:
        full = field.tag.name.lower()
        for name in (field.name, full, full.rpartition(".")[2]):
            meant.setdefault(name, set()).add(f"{FIELD}.{field.name}")
    return {name: next(iter(signals)) for name, signals in meant.items() if len(signals) == 1}


def _kind(field: TagField) -> Kind:
    if field.tag.type == "BOOL":
        return Kind.BIT
    return Kind.CODE if field.tag.type in CODES else Kind.NUMBER


def _bits(field: TagField) -> int:
    kind = FORMATS[field.tag.type]
    return 0 if kind.letter in "df?" else 8 * kind.size


def _values(name: str, element: int | None, block: Block) -> Array:
    column: Array = block.tags[name]
    return np.ascontiguousarray(column if element is None else column[:, element])


def _is_code(signal: Signal, code: int, block: Block) -> Array:
    found: Array = signal.read(block) == code
    return found
