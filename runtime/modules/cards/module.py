"""A card in a slot; its inputs follow their wiring immediately, and its outputs follow the image.

    scan n         the program reads the inputs at the scan's instant
                   the program writes the output words; lamps show them until the next write
    program mode   outputs are off

A cam depends on the state of another slot's machine at the instant of `update`. The exchange advances that
slot first, so slot order does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from scanrack.io_images.cards import DISCRETE16, WORD_BITS, CardKind
from scanrack.io_images.image import Image, signed_word
from typing_extensions import override

from ...loop.events import Event
from ...loop.module import Module, unnoticed
from ...machine.shaft import FAR
from ...machine.spec import INPUT_NAMES
from ..record import ModuleWithMachine, PredictableMachine
from .card_options import Cam, CardOptions

if TYPE_CHECKING:
    from ...loop.module import Words

WORD_MASK = (1 << WORD_BITS) - 1
Contact = Callable[[int], bool]
"""A function that returns whether a contact is operated at an instant in ns."""


class Change(NamedTuple):
    """A change of an input."""

    at_ns: int
    input: str
    operated: bool  # whether a contact is operated or released
    value: Decimal | None  # new value of an analog input


class GenericCard(Module):
    """A simulated card.

    Attributes:
        events: events in order of time; the caller empties the list.
        lit: mask of the digital outputs that are on.
        before_change: function called before any change from outside.

    Raises:
        ValueError: the wiring uses a terminal that this kind of card does not have.
    """

    def __init__(self, options: CardOptions | None = None, kind: CardKind = DISCRETE16) -> None:
        self.options = options or CardOptions()
        self.options.check(kind)
        self.kind = kind
        self.events: list[Event] = []
        self.lit = 0
        self.before_change: Callable[[], None] = unnoticed
        self._levels = self.options.at_rest  # mask of the energized digital inputs
        self._cams: list[tuple[str, Contact]] = []  # with the names of their inputs
        self._horizons: list[Callable[[], int]] = []  # each returns until when a cam keeps its state
        self._changes = sorted(_changes(self.options), key=lambda change: change.at_ns)
        self._next_index = 0  # of the first change that is not applied yet
        self._plc_running = True
        self._image = Image()
        self._channels = self.options.channels(kind)
        self._driven_before: tuple[int, ...] | None = None  # analog output words at the last `update`
        # fixed tables of the digital words, for speed
        self._output_words = [(index, mask, WORD_BITS * index) for index, mask in enumerate(kind.outputs)]
        self._shown_words = range(len(kind.shown))
        self._echo_shift = WORD_BITS * kind.echo_at
        for image, channel in self._channels:  # the word of a signal of 0 depends on the range
            if image == "I":
                self._set_signal(channel, Fraction(0))

    @property
    def follows(self) -> frozenset[int]:
        """The slots that must be advanced before this one; see `runtime.loop.module.Follower`."""
        return self.options.follows

    def join(self, modules: Mapping[int, Module]) -> None:
        """Connect the cams to the machines of other modules.

        Args:
            modules: modules by slot number.

        Raises:
            ValueError: a slot without a simulated machine.
        """
        self._cams = [(cam.input, _contact(cam, modules)) for cam in self.options.cam]
        self._horizons = [_horizon(cam, modules) for cam in self.options.cam]

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        while self._next_index < len(self._changes) and self._changes[self._next_index].at_ns <= now_ns:
            self._apply(self._changes[self._next_index])
            self._next_index += 1
        for name, operated in self._cams:
            self._put_level(name, self._energized(name, operated(now_ns)))
        self.lit = self._outputs(outputs) if self._plc_running else 0
        if not self.kind.analog:
            self._show(self._levels | self.lit << self._echo_shift if self.kind.echo else self._levels)
        # an analog input is in the image as soon as it is set
        elif self.kind.channels_out and (driven := self._driving(outputs)) != self._driven_before:
            self._drive(driven)
        return self._image

    def calm_until_ns(self, outputs: Image) -> int:
        """Return an instant before which no input changes; see `runtime.loop.module.ForeseeingModule`."""
        if self.lit != (self._outputs(outputs) if self._plc_running else 0):
            return 0
        if self.kind.channels_out and self._driving(outputs) != self._driven_before:
            return 0
        change_ns = self._changes[self._next_index].at_ns if self._next_index < len(self._changes) else FAR
        return min([change_ns, *(horizon() for horizon in self._horizons)])

    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """Return no words, because nothing changes before `calm_until_ns`."""
        return {}

    @override
    def plc_run(self, running: bool) -> None:
        if running != self._plc_running:
            self.before_change()
            self._plc_running = running

    @override
    def power_cycle(self) -> None:
        """Do nothing, because contacts keep their state and the next image is the same."""

    def set_input(self, name: str, energized: bool) -> None:
        """Set a digital input; it keeps the level.

        Raises:
            ValueError: an unknown input, an analog input, or an input that a cam operates.
        """
        if self.kind.analog:
            raise ValueError(f"input {name!r} is analog: set its value, not a level")
        self._terminal_of(name)
        if name not in self.options.buttons:
            raise ValueError(f"input {name!r} is wired to a cam; only the machine operates it")
        self.before_change()
        self._put_level(name, energized)

    def end_timeline(self) -> bool:
        """Cancel the remaining presses of the timeline; return whether any remained."""
        self.before_change()
        had_changes = self._next_index < len(self._changes)
        del self._changes[self._next_index :]
        return had_changes

    def _put_level(self, name: str, energized: bool) -> None:
        terminal = self._terminal_of(name)
        self._levels = self._levels | 1 << terminal if energized else self._levels & ~(1 << terminal)

    def set_value(self, name: str, value: float | Decimal) -> None:
        """Set an analog input; it keeps the value.

        Args:
            value: -30 to 30 V or mA for a channel with a range; otherwise the raw number, -32,768 to 32,767.

        Raises:
            ValueError: an unknown input, a digital input, or an invalid value.
        """
        channel_number = self._terminal_of(name)
        if not self.kind.analog:
            raise ValueError(f"input {name!r} is a contact: set its level, not a value")
        exact_value = value if isinstance(value, Decimal) else Decimal(str(value))
        self.options.check_value(name, exact_value)
        self.before_change()
        if ("I", channel_number) in self._channels:
            self._set_signal(channel_number, Fraction(exact_value))
        else:
            self._image[channel_number] = int(exact_value)

    def _set_signal(self, channel_number: int, signal: Fraction) -> None:
        """Convert a signal of an input channel, and set its range bits."""
        channel = self._channels["I", channel_number]
        self._image[channel_number] = channel.word(signal)
        self._show_range("I", channel_number, *channel.signal_beyond(signal))

    def _show_range(self, image: str, channel_number: int, over: bool, under: bool) -> None:
        bits = self.kind.bits[image]
        self._image.set_bit(bits.word, bits.over_bit(channel_number), over)
        self._image.set_bit(bits.word, bits.over_bit(channel_number) + 1, under)
        self._image.set_bit(bits.status_word, channel_number, over or under)

    def _driving(self, outputs: Image) -> tuple[int, ...]:
        """Return the words that drive the analog outputs; 0 while the PLC is not running."""
        return tuple(outputs[index] if self._plc_running else 0 for index in range(self.kind.channels_out))

    def _drive(self, driven: tuple[int, ...]) -> None:
        """Set the analog outputs, their range bits and the echo."""
        self._driven_before = driven
        for index, word in enumerate(driven):
            channel = self._channels.get(("O", index))
            shown_word = word
            if channel is not None:
                used_word = word & ~self.kind.ignored
                shown_word = channel.limited(used_word)
                self._show_range("O", index, *channel.word_beyond(used_word))
            if self.kind.echo:
                self._image[self.kind.echo_at + index] = shown_word

    def _terminal_of(self, name: str) -> int:
        if name not in self.options.inputs:
            input_list = ", ".join(self.options.inputs) or "none"
            raise ValueError(f"no input {name!r}: inputs are {input_list}")
        return self.options.inputs[name]

    def _outputs(self, outputs: Image) -> int:
        """Return the mask of the digital outputs that the words switch on."""
        mask = 0
        for word, terminals, shift in self._output_words:
            mask |= (outputs[word] & terminals) << shift
        return mask

    def _show(self, bits: int) -> None:
        for word in self._shown_words:
            self._image[word] = signed_word(bits >> WORD_BITS * word & WORD_MASK)

    def _energized(self, name: str, operated: bool) -> bool:
        return operated is not (name in self.options.normally_closed)

    def _apply(self, change: Change) -> None:
        """Apply a change of the timeline, and report it as an event."""
        name = change.input
        if change.value is not None:
            self.set_value(name, change.value)
            text = f"The {name} input is {change.value}{self._unit(name)}."
            value = int(change.value) if change.value == int(change.value) else float(change.value)
            self.events.append(Event(change.at_ns, "stimulus", name, text, {"value": value}))
            return
        energized = self._energized(name, change.operated)
        self._put_level(name, energized)
        level_word = "energized" if energized else "de-energized"
        text = f"The {name} input is {level_word}."
        self.events.append(Event(change.at_ns, "stimulus", name, text, {"energized": energized}))

    def _unit(self, name: str) -> str:
        """Return a space and the unit of a channel with a range; otherwise an empty string."""
        channel = self._channels.get(("I", self.options.inputs[name]))
        return "" if channel is None else f" {channel.range.unit}"


def _changes(options: CardOptions) -> Iterator[Change]:
    """Yield the operation of each press in the timeline, and its release if it has an end."""
    for press in options.timeline:
        yield Change(press.begin_ns, press.input, True, press.value)
        if press.end_ns is not None:
            yield Change(press.end_ns, press.input, False, None)


def _contact(cam: Cam, modules: Mapping[int, Module]) -> Contact:
    """Return the function that evaluates a cam."""
    stepper = modules.get(cam.slot)
    if not isinstance(stepper, ModuleWithMachine):
        raise ValueError(f"cam {cam.input}: slot {cam.slot} has no simulated machine")
    return partial(_at_switch if cam.switch is not None else _in_range, cam, stepper)


def _horizon(cam: Cam, modules: Mapping[int, Module]) -> Callable[[], int]:
    """Return a function that predicts how long a cam keeps its state; 0 if its module can't predict."""
    stepper = modules[cam.slot]
    if not isinstance(stepper, PredictableMachine):
        return lambda: 0
    if cam.switch is not None:
        return stepper.levels_calm_until_ns
    return partial(stepper.shaft_calm_until_ns, cam.first, cam.last)


def _at_switch(cam: Cam, stepper: ModuleWithMachine, now_ns: int) -> bool:
    return bool(stepper.machine_at(now_ns).levels(now_ns) & INPUT_NAMES[str(cam.switch)].value)


def _in_range(cam: Cam, stepper: ModuleWithMachine, now_ns: int) -> bool:
    shaft = stepper.machine_at(now_ns).shaft
    return (cam.first is None or shaft >= cam.first) and (cam.last is None or shaft <= cam.last)
