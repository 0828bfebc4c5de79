"""A 3601 that deviates from the model, for example by another interpretation of the manual or a missing rule.

An `Alteration` is data; `Altered3601` is the simulated module with an alteration.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeAlias

from scanrack.io_images.amci3601 import LIVE_BITS, CommandMsw, StatusBits, StatusMsw
from scanrack.io_images.amci3601.words import Profile
from scanrack.io_images.image import Image, signed_word
from typing_extensions import override

from ...loop.events import Event, JsonValue
from ...machine import Machine
from .command_layer import CommandLayer
from .command_words import CommandWords
from .latches import BrokenRule, Latches
from .module import Amci3601
from .operation import Operation
from .refusals import RefusalRule
from .scaled_axis import AxisScales, ScaledGenerator

ImageWords: TypeAlias = tuple[int, ...]
"""The eight signed words of an image."""

MODE_CONFIG = StatusMsw.MODE_CONFIG.value
CONFIGURES = CommandMsw.MODE_CONFIG.value
_WORD = 0xFFFF


@dataclass(frozen=True, slots=True)
class Alteration:
    """A deviation from the model; by default, no attribute deviates.

    Attributes:
        sentence: the deviation, as a sentence about the module.
        options: options of the model; see `Amci3601Options`.
        silent: rules that set no bits when they fire.
        adds: additional bits of word 0 that rules set when they fire.
        overlooked: rules that the module does not check, so that it carries out the command.
        also: additional reasons to refuse a command.
        clears: returns the bits of word 0 that the module clears where the model clears the given bits.
        hidden: status bits of both words that the module does not show.
        during: the kind of motion during and after which bits are hidden; "" for always.
        hears: returns the output words that act when the module receives the given words.
        shows: returns the input words that the module shows where the model shows the given words.
        layer: the class of the module's command layer.
        scales: factors on the rates and speeds of motions.
    """

    sentence: str
    options: Mapping[str, JsonValue] = field(default_factory=dict)
    silent: frozenset[str] = frozenset()
    adds: Mapping[str, int] = field(default_factory=dict)
    overlooked: frozenset[str] = frozenset()
    also: tuple[RefusalRule, ...] = ()
    clears: Callable[[int], int] | None = None
    hidden: StatusBits = 0
    during: str = ""
    hears: Callable[[ImageWords], ImageWords] | None = None
    shows: Callable[[ImageWords], ImageWords] | None = None
    layer: type[AlteredLayer] | None = None
    scales: AxisScales | None = None

    def __deepcopy__(self, _memo: object) -> Alteration:
        return self


class AlteredLatches(Latches):
    """Latches with an alteration."""

    def __init__(self, events: list[Event], profile: Profile, alteration: Alteration) -> None:
        super().__init__(events, profile)
        self._alteration = alteration

    @override
    def _set(self, now_ns: int, rule_id: str, bits: int) -> None:
        """Set the bits of a rule, with the additional bits; a silent rule sets none."""
        alteration = self._alteration
        bits_set = 0 if rule_id in alteration.silent else bits | alteration.adds.get(rule_id, 0)
        super()._set(now_ns, rule_id, bits_set)

    @override
    def clear(self, bits: int) -> None:
        super().clear(bits if self._alteration.clears is None else self._alteration.clears(bits))


class AlteredLayer(CommandLayer):
    """A command layer with an alteration.

    Attributes:
        latest: the kind of the last accepted motion.
    """

    def __init__(self, alteration: Alteration, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.alteration = alteration
        self.latest = ""
        bits = self.state.latches.bits
        self.state.latches = AlteredLatches(self._events, self.profile, alteration)
        self.state.latches.bits = bits

    @override
    def noticed(self, command: CommandWords, faults: list[BrokenRule]) -> list[BrokenRule]:
        """Return the faults without overlooked rules, and with the additional reasons to refuse."""
        noticed_faults = [fault for fault in faults if fault.rule not in self.alteration.overlooked]
        if not command.configures:
            further_rules = self.alteration.also
            noticed_faults += [rule.fault for rule in further_rules if rule.broken(self, command)]
        return noticed_faults

    @override
    def accept(self, operation: Operation) -> None:
        self.latest = operation.name
        super().accept(operation)


class Altered3601(Amci3601):
    """A simulated 3601 with an alteration; see `Amci3601` for the other arguments."""

    def __init__(
        self,
        alteration: Alteration,
        firmware: str = "4.1",
        machine: Machine | None = None,
        *,
        diagnostic_wiring: bool = False,
    ) -> None:
        self.alteration = alteration
        self._layer_of = partial(alteration.layer or AlteredLayer, alteration)
        if alteration.scales is not None:
            self._axis_of = partial(ScaledGenerator, alteration.scales)
        self._altered_image, self._shown = Image(), Image()
        super().__init__(firmware, machine, alteration.options, diagnostic_wiring=diagnostic_wiring)

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance the module with the altered outputs; return the altered input image."""
        image = super().update(now_ns, self._altered_outputs(outputs))
        words = self._masked(tuple(image))
        if self.alteration.shows is not None:
            words = self.alteration.shows(words)
        for number, word in enumerate(words):
            self._shown[number] = word
        return self._shown

    @override
    def calm_until_ns(self, outputs: Image) -> int:
        return super().calm_until_ns(self._altered_outputs(outputs))

    def _altered_outputs(self, outputs: Image) -> Image:
        """Return the altered outputs; a configuration is not altered."""
        hears = self.alteration.hears
        if hears is None or outputs[0] & CONFIGURES:
            return outputs
        for number, word in enumerate(hears(tuple(outputs))):
            self._altered_image[number] = word
        return self._altered_image

    def _masked(self, words: ImageWords) -> ImageWords:
        """Return the input words without the hidden bits."""
        alteration, layer = self.alteration, self.layer
        assert isinstance(layer, AlteredLayer)
        is_other_motion = alteration.during and alteration.during != layer.latest
        if not alteration.hidden or is_other_motion:
            return words
        hidden = alteration.hidden
        if words[0] & MODE_CONFIG:  # the other bits are not status bits in this mode
            hidden &= LIVE_BITS
        msw = signed_word(words[0] & _WORD & ~hidden)
        lsw = signed_word(words[1] & _WORD & ~(hidden >> 16))
        return (msw, lsw, *words[2:])
