"""Options of a card in a rack file: the wiring of its terminals, and a timeline of its inputs.

[slot.options]
inputs = { start = 0, stop = 1, at_two = 2, home = 3 }
outputs = { lamp = 0 }
normally_closed = ["stop"]
timeline = [{ at_ms = 100, input = "start", for_ms = 50 }]
cam = [
    { input = "at_two", slot = 1, first = 3990, last = 4010 },   # the shaft of slot 1
    { input = "home", slot = 1, switch = "home" },               # a switch of its machine
]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from typing import Annotated, ClassVar, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from scanrack.io_images.cards import WORD_BITS, CardKind
from scanrack.io_images.image import WORD_MAX, WORD_MIN, WORDS
from scanrack.io_images.module_words import BitPlace, ModuleWords, numbers_of, terminals_in
from scanrack.io_images.signal_ranges import RANGES, RAW_LANDMARKS, SIGNAL_MAX, Channel
from scanrack.io_images.times import time_text

from ...loop.module_options import Options
from ...machine.spec import INPUT_NAMES

CHANNEL_NAMES = tuple(f"ch{channel}_data" for channel in range(WORDS))
WORD_NAMES = ("data", *(f"word{index}" for index in range(1, WORDS)))


def _exact(value: object) -> object:
    """Return a number as the exact decimal that the user wrote."""
    return Decimal(str(value)) if isinstance(value, int | float) and not isinstance(value, bool) else value


Terminal = Annotated[int, Field(ge=0)]
Milliseconds = Annotated[Decimal, BeforeValidator(_exact), Field(ge=0, le=10**9, decimal_places=6)]
Seconds = Annotated[Decimal, BeforeValidator(_exact), Field(ge=0, le=10**6, decimal_places=9)]


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, defer_build=True)


class InputPress(_Row):
    """An operation of an input, or a new value of an analog input.

    Attributes:
        at_ms: time since power-up, ms; or `at_s`.
        input: one of `inputs`.
        for_ms: duration, ms; or `for_s`. Unlimited by default.
        value: new value of an analog input, in V or mA if the input has a range in `ranges`, otherwise the
            raw number.
    """

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    input: str
    for_ms: Annotated[Milliseconds, Field(gt=0)] | None = None
    for_s: Annotated[Seconds, Field(gt=0)] | None = None
    value: Annotated[Decimal, BeforeValidator(_exact), Field(ge=WORD_MIN, le=WORD_MAX)] | None = None

    @property
    def begin_ns(self) -> int:
        """Start time, ns since power-up."""
        return _ns(self.at_ms, self.at_s) or 0

    @property
    def end_ns(self) -> int | None:
        """End time, ns since power-up, or None without an end."""
        duration_ns = _ns(self.for_ms, self.for_s)
        return None if duration_ns is None else self.begin_ns + duration_ns

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        if (self.at_ms is None) is (self.at_s is None):
            raise ValueError("one of at_ms and at_s is needed")
        if self.for_ms is not None and self.for_s is not None:
            raise ValueError("use for_ms or for_s, not both")
        return self


def _ns(ms: Decimal | None, s: Decimal | None) -> int | None:
    """Return a time in ns, converted from ms or s, or None if neither is given."""
    if ms is not None:
        return int(ms * 10**6)
    return None if s is None else int(s * 10**9)


class Cam(_Row):
    """A contact that is operated by the machine of a stepper in another slot.

    Attributes:
        input: one of `inputs`.
        slot: slot of the stepper.
        first: lowest position of the shaft that operates the input, steps; unlimited by default.
        last: highest position that operates the input, steps; unlimited by default.
        switch: a switch of the stepper's machine, such as "home", used instead of positions.
    """

    input: str
    slot: Annotated[int, Field(ge=1)]
    first: int | None = None
    last: int | None = None
    switch: str | None = None

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        has_range = self.first is not None or self.last is not None
        if has_range is (self.switch is not None):
            raise ValueError("a cam needs a switch, or first, last or both")
        if self.switch is not None and self.switch not in INPUT_NAMES:
            raise ValueError(f"no switch {self.switch!r}; choose from {', '.join(INPUT_NAMES)}")
        if self.first is not None and self.last is not None and self.first > self.last:
            raise ValueError(f"first {self.first} is above last {self.last}")
        return self


class CardOptions(Options):
    """The wiring of a card.

    Attributes:
        inputs: names of inputs by terminal, or of analog inputs by channel.
        outputs: names of outputs by terminal or channel.
        timeline: operations of inputs, and new values of analog inputs.
        normally_closed: inputs with contacts that are closed at rest; an operated input is de-energized.
        cam: inputs that are operated by the machine of another slot.
        ranges: ranges of an analog card's channels by name, such as "4..20 mA"; the card converts their
            signals and shows over-range and under-range.
        formats: data formats of an analog card's channels that have a range; "raw" by default.
    """

    owner: ClassVar[str] = "card"

    inputs: Mapping[str, Terminal] = Field(default_factory=dict)
    outputs: Mapping[str, Terminal] = Field(default_factory=dict)
    normally_closed: Annotated[tuple[str, ...], Field(strict=False)] = ()
    timeline: Annotated[tuple[InputPress, ...], Field(strict=False)] = ()
    cam: Annotated[tuple[Cam, ...], Field(strict=False)] = ()
    ranges: Mapping[str, str] = Field(default_factory=dict)
    formats: Mapping[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        """Refuse names that are invalid, repeated or not wired, and operations that conflict."""
        for field in ("inputs", "outputs"):
            _check_names(field, getattr(self, field))
        shared_names = sorted(set(self.inputs) & set(self.outputs))
        if shared_names:
            raise ValueError(f"{shared_names[0]!r} names an input and an output; rename one of them")
        _check_presses(self.timeline)
        input_list = ", ".join(self.inputs) or "none"
        cam_inputs = [cam.input for cam in self.cam]
        timeline_inputs = [press.input for press in self.timeline]
        for name in (*self.normally_closed, *timeline_inputs, *cam_inputs):
            if name not in self.inputs:
                raise ValueError(f"no input {name!r}: inputs are {input_list}")
        for name in cam_inputs:
            if name in timeline_inputs or cam_inputs.count(name) > 1:
                raise ValueError(f"cam: {name!r} is wired twice; use one cam, or the timeline")
        return self

    def check(self, kind: CardKind) -> None:
        """Check that the wiring fits a kind of card.

        Raises:
            ValueError: a terminal or channel does not exist on the card, or an analog card has a contact.
        """
        for field, image, masks in (("inputs", "I", kind.inputs), ("outputs", "O", kind.outputs)):
            channels = [(1 << kind.channels[image]) - 1]  # a mask as of terminals, one bit per channel
            _check_terminals(kind, field, getattr(self, field), channels if kind.analog else masks)
        if kind.analog and (self.normally_closed or self.cam):
            raise ValueError(f"a {kind.name} has no contacts; remove normally_closed and cam")
        for press in self.timeline:
            self._check_press(press, analog=kind.analog)
        self._check_ranges(kind)

    def _check_press(self, press: InputPress, *, analog: bool) -> None:
        """Refuse an operation that does not fit the kind of the input, and an illegal value."""
        has_value = press.value is not None
        if analog != has_value:
            reason = "needs a value" if analog else "is a contact and has no value"
            raise ValueError(f"timeline: {press.input!r} {reason}")
        if analog and press.end_ns is not None:
            raise ValueError(f"timeline: {press.input!r} keeps its value until the next one; remove for_ms")
        if press.value is not None:
            self.check_value(press.input, press.value)

    def _check_ranges(self, kind: CardKind) -> None:
        """Refuse a range or format that the card lacks, an unknown channel, or a format without a range."""
        for name, choice in self.ranges.items():
            _check_choice(f"ranges: {name!r}", choice, kind.ranges, kind.name)
            if name not in self.inputs and name not in self.outputs:
                channel_list = ", ".join((*self.inputs, *self.outputs)) or "none"
                raise ValueError(f"ranges: no channel {name!r}: channels are {channel_list}")
        for name, choice in self.formats.items():
            _check_choice(f"formats: {name!r}", choice, tuple(kind.formats), kind.name)
            if name not in self.ranges:
                raise ValueError(f"formats: {name!r} has no range; add it to ranges")
            if choice == "percent" and RANGES[self.ranges[name]].low < 0:
                raise ValueError(f"formats: {name!r}: a range of {self.ranges[name]} has no percent format")

    def check_value(self, name: str, value: Decimal) -> None:
        """Check a value of an analog input.

        Raises:
            ValueError: a signal beyond 30 V or mA; without a range, a number that is not a word.
        """
        if name in self.ranges:
            if abs(value) > SIGNAL_MAX:
                unit = self.ranges[name].rpartition(" ")[2]
                raise ValueError(f"{name!r}: {value} {unit} must be -{SIGNAL_MAX} to {SIGNAL_MAX}")
        elif value != int(value) or not WORD_MIN <= value <= WORD_MAX:
            raise ValueError(
                f"{name!r}: {value} is not a word: must be {WORD_MIN} to {WORD_MAX}; "
                "for V or mA, add the input to ranges"
            )

    def channel_of(self, name: str) -> tuple[str, int]:
        """Return the image, "I" or "O", and the number of a wired channel."""
        return ("I", self.inputs[name]) if name in self.inputs else ("O", self.outputs[name])

    def channels(self, kind: CardKind) -> dict[tuple[str, int], Channel]:
        """Return the channels with a range, by image and number."""
        return {
            self.channel_of(name): Channel(RANGES[choice], kind.formats[self.formats.get(name, "raw")])
            for name, choice in self.ranges.items()
        }

    @property
    def at_rest(self) -> int:
        """Mask of the inputs that are energized at rest."""
        return sum(1 << self.inputs[name] for name in set(self.normally_closed))

    @property
    def follows(self) -> frozenset[int]:
        """The slots whose machines operate inputs."""
        return frozenset(cam.slot for cam in self.cam)

    @property
    def buttons(self) -> tuple[str, ...]:
        """The inputs that only a person operates."""
        cam_inputs = {cam.input for cam in self.cam}
        return tuple(name for name in self.inputs if name not in cam_inputs)

    @property
    def signals(self) -> dict[str, tuple[float, ...]]:
        """Inputs of an analog card, with test values at the ends, in the middle and beyond the ends."""
        return {
            name: RANGES[self.ranges[name]].landmarks if name in self.ranges else RAW_LANDMARKS
            for name in self.inputs
        }

    def words(self, kind: CardKind) -> ModuleWords:
        """Return the names of the words and bits of a card with this wiring."""
        words = _analog_words(kind, self) if kind.analog else _digital_words(kind, self)
        return replace(words, card=kind.name)


def _digital_words(kind: CardKind, options: CardOptions) -> ModuleWords:
    """Return the words of a digital card; each wired terminal is a named bit."""
    return ModuleWords(
        "Discrete",
        outputs=WORD_NAMES,
        inputs=WORD_NAMES,
        groups={
            "input": {
                name: BitPlace("I", *divmod(terminal, WORD_BITS)) for name, terminal in options.inputs.items()
            },
            "output": {
                name: BitPlace("O", *divmod(terminal, WORD_BITS))
                for name, terminal in options.outputs.items()
            },
        },
        data_bits=kind.data_bits,
        terminals={"I": kind.shown, "O": kind.outputs},
    )


def _analog_words(kind: CardKind, options: CardOptions) -> ModuleWords:
    """Return words named after the wired channels.

    The stem of the message types contains the wiring, so that different wirings have different types.
    """
    images: dict[str, tuple[str, ...]] = {}
    profile: dict[str, tuple[str, int]] = {}
    stem = "Analog"
    for image, channels_by_name in (("I", options.inputs), ("O", options.outputs)):
        channels = kind.channels[image]
        names = [f"ch{index}_data" if index < channels else f"word{index}" for index in range(WORDS)]
        for channel, name in sorted((channel, name) for name, channel in channels_by_name.items()):
            names[channel] = name
            stem += f"{image}{channel}{name.title().replace('_', '')}"
        images[image] = tuple(names)
        profile |= {f"Ch{number}Data": (image, number) for number in range(channels)}
    if kind.channels_out and not options.outputs:
        stem += "Out"
    ranges = _range_bits(kind, options) if options.ranges else {}
    groups = {"status": ranges} if options.ranges else {}
    return ModuleWords(stem, images["O"], images["I"], groups, profile_words=profile, errors=tuple(ranges))


def _range_bits(kind: CardKind, options: CardOptions) -> dict[str, BitPlace]:
    """Return the range bits of channels with a range, for example `level_over`, `level_under`."""
    bit_places = {}
    for name in options.ranges:
        image, channel = options.channel_of(name)
        bits = kind.bits[image]
        bit_places[f"{name}_over"] = BitPlace("I", bits.word, bits.over_bit(channel))
        bit_places[f"{name}_under"] = BitPlace("I", bits.word, bits.over_bit(channel) + 1)
    return bit_places


def _check_presses(timeline: Sequence[InputPress]) -> None:
    """Check that presses of an input do not overlap, and that no input gets two values at one instant."""
    last_presses: dict[str, InputPress] = {}
    for press in sorted(timeline, key=lambda press: press.begin_ns):
        previous = last_presses.get(press.input)
        last_presses[press.input] = press
        if previous is None:
            continue
        end_ns = previous.begin_ns + 1 if previous.value is not None else previous.end_ns
        if end_ns is None or press.begin_ns < end_ns:
            until = "on" if end_ns is None else f"to {time_text(end_ns)}"
            raise ValueError(
                f"timeline: {press.input!r} is pressed at {time_text(press.begin_ns)}, but also from "
                f"{time_text(previous.begin_ns)} {until}; presses must not overlap"
            )


def _check_choice(key: str, chosen: str, allowed: Sequence[str], card: str) -> None:
    if chosen not in allowed:
        problem = f"a {card} has {', '.join(allowed)}" if allowed else f"a {card} has no channels"
        raise ValueError(f"{key} = {chosen!r}: {problem}")


def _check_names(field: str, names: Mapping[str, int]) -> None:
    """Refuse names that are not plain or already name a word, and terminals that are used twice."""
    for name in names:
        if not (name.isascii() and name.isidentifier() and name == name.lower()):
            raise ValueError(f"{field}: {name!r} is not a name: use small letters, digits and _ only")
        if name in WORD_NAMES or name in CHANNEL_NAMES:
            raise ValueError(f"{field}: {name!r} is the name of a word: choose another name")
    terminals = list(names.values())
    for name, terminal in names.items():
        if terminals.count(terminal) > 1:
            raise ValueError(f"{field}: terminal {terminal} of {name!r} is used twice")


def _check_terminals(kind: CardKind, field: str, names: Mapping[str, int], masks: Sequence[int]) -> None:
    """Refuse terminals or channels that the card does not have."""
    noun = "channel" if kind.analog else "terminal"
    if names and not any(masks):
        raise ValueError(f"{field}: a {kind.name} has no {field}")
    for name, terminal in names.items():
        if terminal not in terminals_in(masks):
            raise ValueError(
                f"{field}: {name!r}: a {kind.name} has no {noun} {terminal}: {numbers_of(masks)}"
            )
