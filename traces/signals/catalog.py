"""Every signal of a rack, by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from functools import partial
from types import MappingProxyType

import numpy as np
from scanrack.io_images.module_words import INPUT, ModuleWords, Quantity
from scanrack.io_images.tag_names import AmbiguousNameError, normal

from ..format.layout import SlotInfo
from ..format.tagplan import TagPlan
from ..read.number_formats import NumberFormats
from ..read.reader import Trace
from ..read.sequence_steps import sequence_steps
from . import decode
from .names import DIRECTIONS, SignalNames, first_titles, is_named
from .sequences import Steps, sequence_signals
from .signal import Array, Signal, SignalKind
from .stream import Block
from .tags import constant, tag_signals

FLAGS = Signal("cpu.flags", SignalKind.WORD, lambda block: block.flags)
"""The controller's flags as recorded; see the table of flags in docs/traces.md."""

NO_TEXTS: Mapping[int, str] = MappingProxyType({})
NO_STEPS: Steps = MappingProxyType({})


class UnknownSignalError(ValueError):
    """No signal, or more than one signal, has this name."""


class Catalog(Mapping[str, Signal]):
    """The signals of a rack by name. The order in each slot is speed, values, bits, words.

    A bit without its own name has a numbered name such as `slot1.in.word3.12`; the catalog finds these names,
    but does not list them.

    Args:
        texts: text by code, for tags of type TEXT.
        sequences: the steps of each sequence.
        formats: number formats of modules whose configuration selects them.
    """

    def __init__(
        self,
        slots: Sequence[SlotInfo],
        tags: TagPlan | None = None,
        texts: Mapping[int, str] = NO_TEXTS,
        sequences: Steps = NO_STEPS,
        formats: NumberFormats | None = None,
    ) -> None:
        self.slots = tuple(slots)
        slot_formats = NumberFormats() if formats is None else formats
        signals = [FLAGS, *(signal for slot in slots for signal in _slot_signals(slot, slot_formats))]
        # words whose bits or values are signals
        self._covered = {name for slot in slots for name in _covered_words(slot)}
        if tags is not None:
            signals += tag_signals(tags, texts)
        signals += sequence_signals(sequences)
        self._names = SignalNames(signals, slots)
        self._signals = {signal.name: signal for signal in signals}

    @classmethod
    def of(cls, trace: Trace) -> Catalog:
        """Return the signals of a trace."""
        formats = NumberFormats.of(trace)
        return cls(trace.head.slots, trace.head.tags, trace.texts(), sequence_steps(trace), formats)

    def __getitem__(self, name: str) -> Signal:
        """Return a signal by its name in the trace or the program, or by an image address.

        Raises:
            UnknownSignalError: the name is unknown (the message has similar names) or ambiguous.
        """
        try:
            signal = self._by_listed_name(name) or self._by_other_name(name)
        except AmbiguousNameError as error:
            raise UnknownSignalError(str(error)) from None
        if signal is None:
            raise UnknownSignalError(self._unknown(name))
        return signal

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and bool(self._by_listed_name(name) or self._by_other_name(name))
        except AmbiguousNameError:
            return False

    def __iter__(self) -> Iterator[str]:
        return iter(self._signals)

    def __len__(self) -> int:
        return len(self._signals)

    @property
    def tags(self) -> list[Signal]:
        """The signals of the recorded tags, and the waits of each sequence."""
        return [signal for signal in self._signals.values() if signal.title]

    def matching(self, patterns: Sequence[str]) -> list[Signal]:
        """Return the signals that match at least one pattern, in the catalog's order.

        Args:
            patterns: names, with `*` and `?` as in file names; a tag's name may be its name in the program.
                Empty = all signals except words whose bits or values are signals.

        Raises:
            UnknownSignalError: a pattern matches nothing.
        """
        if not patterns:
            return [signal for signal in self._signals.values() if self._is_plain(signal)]
        names: dict[str, None] = {}
        for pattern in patterns:
            names.update(dict.fromkeys(self._names_of(pattern)))
        order = {name: index for index, name in enumerate(self._signals)}
        return [self[name] for name in sorted(names, key=lambda name: order.get(name, len(order)))]

    def _names_of(self, pattern: str) -> list[str]:
        """Return the matching signals, or else the matching tags, or else the signal with that name."""
        matches = [name for name in self._signals if fnmatchcase(name, pattern)]
        return matches or [signal.name for signal in self.tags_named(pattern)] or [self[pattern].name]

    def tags_named(self, pattern: str) -> list[Signal]:
        """Return the recorded tags that match a pattern.

        Raises:
            UnknownSignalError: several programs have a tag with that name.
        """
        try:
            member = self._names.scoped(pattern)
        except AmbiguousNameError as error:
            raise UnknownSignalError(str(error)) from None
        return [signal for signal in self.tags if is_named(signal, member)]

    def _is_plain(self, signal: Signal) -> bool:
        if signal.kind is not SignalKind.WORD or signal is FLAGS:
            return True
        return signal.name not in self._covered

    def _by_listed_name(self, name: str) -> Signal | None:
        return self._signals.get(name) or self._numbered_bit(name) or self._constant(name)

    def _by_other_name(self, name: str) -> Signal | None:
        """Return the signal for a tag's name in the program, a terminal, an address, or part of these."""
        name = normal(name)
        signal_name = self._names.find(name)
        if signal_name is not None:
            return self._by_listed_name(signal_name)
        parent, dot, member = name.replace("/", ".").rpartition(".")
        parent_name = self._names.find(parent) if dot else None
        return None if parent_name is None else self._by_listed_name(f"{parent_name}.{member}")

    def _constant(self, name: str) -> Signal | None:
        code, _, member = name.rpartition(".")
        return constant(self._signals[code], member) if code in self._signals else None

    def _numbered_bit(self, name: str) -> Signal | None:
        """Return the signal of a bit such as `slot1.in.word3.12`; None if the bit does not exist."""
        word, _, number = name.rpartition(".")
        source = self._signals.get(word)
        if source is None or source.kind not in (SignalKind.WORD, SignalKind.NUMBER):
            return None
        word_width = 32 if source is FLAGS else 16
        width = source.bits if source.kind is SignalKind.NUMBER else word_width
        if not (number.isdecimal() and number.isascii() and int(number) < width):
            return None
        return Signal(name, SignalKind.BIT, partial(_bit_of, source, int(number)))

    def _close_to(self, name: str) -> list[str]:
        """Return the signals with similar names, otherwise the signals with a similar last part."""
        by_lower_name = {signal_name.lower(): signal_name for signal_name in self._signals}
        close_names = get_close_matches(name.lower(), list(by_lower_name), 3, 0.7)
        if close_names:
            return [by_lower_name[close_name] for close_name in close_names]
        last_parts = {signal_name: signal_name.rpartition(".")[2].lower() for signal_name in self._signals}
        last_part = name.rpartition(".")[2].lower()
        close_parts = get_close_matches(last_part, sorted({*last_parts.values()}), 2, 0.7)
        return [signal_name for signal_name, part in last_parts.items() if part in close_parts][:4]

    def _unknown(self, name: str) -> str:
        """Return a message about an unknown name, which lists similar names or the values of an array."""
        titles = [signal.title for signal in self.tags_named(name)]
        if titles:
            return f"{name} has {len(titles)} values: write {' or '.join(first_titles(titles, 3))}"
        close_names = self._close_to(name)
        slots = ", ".join(f"slot{slot.number}" for slot in self.slots)
        hint = (
            f"did you mean {' or '.join(close_names)}?"
            if close_names
            else f"the trace has cpu.flags and signals of {slots}"
        )
        return f"no signal {name!r}: {hint}"


def _slot_signals(slot: SlotInfo, formats: NumberFormats) -> Iterator[Signal]:
    """Yield the signals of a slot: its speed, values, named bits and words."""
    number, stem, words = slot.number, f"slot{slot.number}", slot.words
    position = words.quantity("position")
    if position is not None:
        read_speed = partial(_speed, number, words, position, formats)
        yield Signal(f"{stem}.speed", SignalKind.MEASURED, read_speed)
    for quantity in words.quantities:
        if quantity.words > 1:
            value = partial(_value, number, words, quantity, formats)
            yield Signal(f"{stem}.{DIRECTIONS[quantity.image]}.{quantity.name}", SignalKind.VALUE, value)
    yield from _named_bits(slot, stem)
    for direction in DIRECTIONS.values():
        for word, name in enumerate(words.named(direction)):
            read_word = partial(_word, number, direction, word)
            yield Signal(f"{stem}.{direction}.{name}", SignalKind.WORD, read_word)


def _covered_words(slot: SlotInfo) -> Iterator[str]:
    """Yield the names of words whose bits or values are signals."""
    for direction in DIRECTIONS.values():
        names = slot.words.named(direction)
        for word in slot.words.covered(direction):
            yield f"slot{slot.number}.{direction}.{names[word]}"


def _named_bits(slot: SlotInfo, stem: str) -> Iterator[Signal]:
    """Yield the signals of a slot's named bits; inputs come first if the module has two modes."""
    places = [(name, place) for names in slot.words.groups.values() for name, place in names.items()]
    if slot.words.modes is not None:
        places.sort(key=lambda name_and_place: name_and_place[1].image not in INPUT)  # inputs first
    for name, (image, word, bit) in places:
        direction = DIRECTIONS[image]
        read_bit = partial(_bit, slot.number, slot.words, direction, word, 1 << bit)
        yield Signal(f"{stem}.{direction}.{name}", SignalKind.BIT, read_bit)


def _word(slot: int, direction: str, word: int, block: Block) -> Array:
    return np.ascontiguousarray(block.image(slot, direction)[:, word])


def _bit(slot: int, words: ModuleWords, direction: str, word: int, mask: int, block: Block) -> Array:
    return decode.module_bit(block.image(slot, direction), words, direction, word, mask)


def _value(slot: int, words: ModuleWords, quantity: Quantity, formats: NumberFormats, block: Block) -> Array:
    image = block.image(slot, DIRECTIONS[quantity.image])
    return _blanked(words, quantity, image, formats.values(slot, quantity, block.scan, image))


def _speed(slot: int, words: ModuleWords, position: Quantity, formats: NumberFormats, block: Block) -> Array:
    """Return the measured speed in each scan of a block.

    It depends on earlier and later positions, so the block's neighboring scans are read as well.
    """
    image = block.wide_image(slot, "in")
    positions = _blanked(words, position, image, formats.values(slot, position, block.wide.scan, image))
    wide_speed = decode.speed(decode.travel(image, words, positions), block.wide.time_ns, block.margin)
    return wide_speed[block.start : block.stop]


def _blanked(words: ModuleWords, quantity: Quantity, image: Array, values: Array) -> Array:
    """Return values, with NaN in configuration mode."""
    if words.modes is not None:
        values[~decode.in_command_mode(image, words.modes.word(quantity.image))] = np.nan
    return values


def _bit_of(word: Signal, number: int, block: Block) -> Array:
    bits: Array = (word.read(block).astype(np.int64) >> number & 1).astype(bool)
    return bits
