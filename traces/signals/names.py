"""Finds signals by the names that users write: from the program, the rack or the trace."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from scanrack.io_images.addresses import parse_address
from scanrack.io_images.tag_names import AmbiguousNameError, base_of, in_scope, key_of, normal

from ..format.layout import SlotInfo
from ..format.tagplan import FIELD
from .sequences import FIELD as SEQUENCES
from .signal import Signal

RECORDED = f"{FIELD}.", f"{SEQUENCES}."
"""Prefixes of the program's signals."""

DIRECTIONS = {"I": "in", "O": "out"}

_SUBSCRIPTS = re.compile(r"\[[^\]]*\]")
_TRACE_NAME = re.compile(r"\s*slot", re.IGNORECASE)
_WILD = re.compile(r"[*?]")


class SignalNames:
    """Names of the tags and terminals of a trace."""

    def __init__(self, signals: Iterable[Signal], slots: Sequence[SlotInfo]) -> None:
        recorded = [signal for signal in signals if signal.name.startswith(RECORDED)]
        self._fields = {signal.name.partition(".")[2].lower(): signal.name for signal in recorded}
        self._tags = [signal for signal in recorded if signal.title]
        self._slots = slots

    def find(self, text: str) -> str | None:
        """Return a signal's name in the trace; None for an unknown name.

        Raises:
            AmbiguousNameError: several signals have the name.
        """
        scoped = in_scope(text, self._bases)
        key = key_of(scoped) or scoped.lower()
        return self._by_key.get(key) or self._by_part(key) or self._name_at_address(text)

    def scoped(self, pattern: str) -> str:
        """Return a pattern qualified with the name of its program; see `in_scope`.

        Raises:
            AmbiguousNameError: several programs have a tag with that name.
        """
        return pattern if _WILD.search(pattern) else in_scope(pattern, self._bases)

    @cached_property
    def _bases(self) -> list[str]:
        return list(dict.fromkeys(base_of(signal.title) for signal in self._tags))

    @cached_property
    def _by_key(self) -> Mapping[str, str]:
        titles = {key_of(signal.title) or signal.title.lower(): signal.name for signal in self._tags}
        return self._fields | titles

    @cached_property
    def _parts(self) -> Mapping[str, list[str]]:
        """Names of signals, by the last part of a tag's name or by a terminal's name."""
        names_by_part: dict[str, list[str]] = {}
        for signal in self._tags:
            last_part = (key_of(signal.title) or signal.title.lower()).rpartition(".")[2]
            names_by_part.setdefault(last_part, []).append(signal.name)
        for slot in self._slots:
            for names in slot.words.groups.values() if slot.words.modes is None else ():
                for name, place in names.items():
                    signal_name = f"slot{slot.number}.{DIRECTIONS[place.image]}.{name}"
                    names_by_part.setdefault(name.lower(), []).append(signal_name)
        return names_by_part

    def _by_part(self, key: str) -> str | None:
        """Return the only signal with a last part, or None; raise AmbiguousNameError if there are several."""
        names = self._parts.get(key, [])
        if len(names) > 1:
            choices = " or ".join(names[:4]) + (" or ..." if len(names) > 4 else "")
            raise AmbiguousNameError(f"{key} is ambiguous: it is {choices}")
        return names[0] if names else None

    def _name_at_address(self, text: str) -> str | None:
        """Return the name of the word or bit at an address; None if the text is not an address.

        An address such as `Local:1:I.Data[0].3` refers to the bit in both modes of a stepper. A bit's name
        refers only to command mode.
        """
        words = {slot.number: slot.words for slot in self._slots}
        try:
            address = parse_address(text, words)
        except ValueError:
            return None
        stem = f"slot{address.slot}.{DIRECTIONS[address.image]}"
        module = words[address.slot]
        bit_names = [name for name, bit in module.bits(address.image, address.word) if bit == address.bit]
        if bit_names and (module.modes is None or _TRACE_NAME.match(text)):
            return f"{stem}.{bit_names[0]}"
        word = module.named(address.image)[address.word]
        return f"{stem}.{word}" if address.bit is None else f"{stem}.{word}.{address.bit}"


def is_named(signal: Signal, pattern: str) -> bool:
    r"""Return whether a pattern matches a tag's name in the trace, or the end of its full name.

    `*` and `?` are wildcards, and brackets are subscripts; case does not matter. As in a rack file, a name
    also matches its members and elements.

    >>> from .signal import SignalKind
    >>> kind = SignalKind.NUMBER
    >>> signal = Signal("tags.main_fill_acc", kind, lambda block: block.flags, title=r"\Main.Fill.ACC")
    >>> [is_named(signal, each) for each in ("tags.*", "main_fill*", r"\main.fill", "fill.acc", "ACC", "Fi")]
    [True, True, True, True, True, False]
    """
    if not signal.title:
        return False
    normalized = normal(pattern) if _WILD.search(pattern) else key_of(pattern) or pattern
    text = "".join({"*": ".*", "?": "."}.get(character, re.escape(character)) for character in normalized)
    name_or_parent = re.compile(rf"{text}(?:[.\[]|$)", re.IGNORECASE)
    full_name = key_of(signal.title) or signal.title
    candidates = [signal.name, signal.name.removeprefix(f"{FIELD}.")]
    for name in (full_name, _SUBSCRIPTS.sub("", full_name)):
        parts = name.split(".")
        candidates += [".".join(parts[start:]) for start in range(len(parts))]
    return any(map(name_or_parent.match, candidates))


def first_titles(titles: Sequence[str], most: int) -> list[str]:
    """Return the first titles for a message, followed by "..." if there are more.

    >>> first_titles(["A", "B"], 2), first_titles(["A", "B", "C"], 2)
    (['A', 'B'], ['A', 'B', '...'])
    """
    return list(titles) if len(titles) <= most else [*titles[:most], "..."]
