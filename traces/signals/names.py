"""Names of signals as people write them: from the program, the rack or the trace."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.tag_names import AmbiguousNameError, base_of, in_scope, key_of, normal

from ..format.layout import SlotInfo
from ..format.tagplan import FIELD
from .sequences import FIELD as SEQUENCES
from .signal import Signal

RECORDED = f"{FIELD}.", f"{SEQUENCES}."
"""Prefixes of the program's signals."""

DIRECTIONS = {"I": "in", "O": "out"}

_SUBSCRIPTS = re.compile(r"\[[^\]]*\]")
_BY_MEANING = re.compile(r"\s*slot", re.IGNORECASE)
_WILD = re.compile(r"[*?]")


class SignalNames:
    """Names of the tags and terminals of a trace."""

    def __init__(self, signals: Iterable[Signal], slots: Sequence[SlotInfo]) -> None:
        recorded = [signal for signal in signals if signal.name.startswith(RECORDED)]
        self._fields = {signal.name.partition(".")[2].lower(): signal.name for signal in recorded}
        self._tags = [signal for signal in recorded if signal.title]
        self._slots = slots

    def __call__(self, text: str) -> str | None:
        """Return the signal with a name, or None; raise an AmbiguousNameError if there are several."""
        scoped = in_scope(text, self._bases)
        key = key_of(scoped) or scoped.lower()
        return self._by_key.get(key) or self._by_part(key) or self._of_image(text)

    def scoped(self, pattern: str) -> str:
        """Return a pattern, with its program added; see `in_scope`.

        Raises:
            AmbiguousNameError: several programs have a tag of that name.
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
        """Names of signals by the last part of a tag's name, and by the name of a terminal."""
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
        meant = self._parts.get(key, [])
        if len(meant) > 1:
            meanings = " or ".join(meant[:4]) + (" or ..." if len(meant) > 4 else "")
            raise AmbiguousNameError(f"{key} is ambiguous: it is {meanings}")
        return meant[0] if meant else None

    def _of_image(self, text: str) -> str | None:
        """Return the signal of the word or bit at an address."""
        words = {slot.number: slot.words for slot in self._slots}
        try:
            address = parse_address(text, words)
        except ValueError:
            return None
        direction = DIRECTIONS[address.image]
        stem = f"slot{address.slot}.{direction}"
        by_meaning = _BY_MEANING.match(text) or not self._has_modes(address)
        name = next(
            (
                name
                for name, bit in words[address.slot].bits(address.image, address.word)
                if bit == address.bit
            ),
            None,
        )
        if name is not None and by_meaning:
            return f"{stem}.{name}"
        word = (words[address.slot].inputs if address.image == "I" else words[address.slot].outputs)[
            address.word
        ]
        return f"{stem}.{word}" if address.bit is None else f"{stem}.{word}.{address.bit}"

    def _has_modes(self, at: Address) -> bool:
        return next(slot.words.modes is not None for slot in self._slots if slot.number == at.slot)


def is_named(signal: Signal, pattern: str) -> bool:
    r"""Return whether a pattern means a tag, by name in the trace, by full name, or by the last part of that.

    `*` and `?` are wildcards, brackets are subscripts; case does not matter. As in a rack file, a name
    means all members and elements below it.

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
    begins = re.compile(rf"{text}(?:[.\[]|$)", re.IGNORECASE)
    key = key_of(signal.title) or signal.title
    names = [signal.name, signal.name.removeprefix(f"{FIELD}.")]
    for name in dict.fromkeys((key, _SUBSCRIPTS.sub("", key))):
        names += [name[start:] for start in (0, *(dot.start() + 1 for dot in re.finditer(r"\.", name)))]
    return any(begins.match(name) for name in names)
