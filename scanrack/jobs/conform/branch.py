"""A hypothesis: one run of the model with one choice of instants."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from scanrack.io_images.amci3601 import COMPLETION_BITS, ERROR_BITS, Configuration, InputBit, StatusMsw
from scanrack.io_images.image import Image
from scanrack.runtime.kinematics import PICO, Motion
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.runtime.modules.amci3601.operation import Operation

from .moments import ImageWords, KnownState, SeenImage, Timing, Transmission

GRID_NS = 500_000
"""Time between tried instants, ns."""

SAMPLE_NS = 250_000
"""Time between stored images of the model, ns; equal to the module's own scan."""

CALM_SAMPLE_NS = 1_000_000
"""Time between stored images while only the position changes, ns."""

MODE_CONFIG = StatusMsw.MODE_CONFIG.value
KEPT = (COMPLETION_BITS | ERROR_BITS).value & 0x1FFF
"""Status bits that may remain set after a configuration, according to reading A-102."""

FINER = 1_000_000
"""Travels count as equal if they differ by less than 1/FINER of a step. Plans are rounded far more finely."""

_OWNERS = ("host", "axis", "state", "started_ns")
"""Attributes of an operation that do not count as its state: its owners, and when it began."""

_PAIRS = (2, 4, 6)


class Branch:
    """One run of the model with one choice of instants.

    Attributes:
        instants: the instants when the transmissions act, in order, ns.
        fired: rules that have fired.
        play: position uncertainty in steps that arises when words act between two tried instants.
    """

    __slots__ = ("_model", "_outputs", "_samples", "fired", "instants", "now_ns", "play")

    def __init__(self, model: Amci3601, start_ns: int) -> None:
        """Start a run of a freshly powered-up model at an instant."""
        self._model = model
        self._outputs = Image()
        self._samples: list[tuple[int, ImageWords]] = []
        self.now_ns = start_ns
        self.instants: tuple[int, ...] = ()
        self.fired: set[str] = set()
        self.play = 0

    def resume(self, state: KnownState) -> Branch:
        """Load the state that an image shows; return this branch."""
        configuration = None
        if any(state.configuration):
            configuration = Configuration.from_image(Image(state.configuration), self._model.firmware)
        for bit in InputBit:
            self._model.operate(bit, bool(state.inputs & bit))
        self._outputs.load(Image(state.sent))
        unsigned = [word & 0xFFFF for word in state.words]
        self._model.take_state(self.now_ns, self._outputs, unsigned, configuration)
        self._sample(self.now_ns)
        return self

    def child(self, keep_from_ns: int) -> Branch:
        """Return a copy with the images from an instant on."""
        twin = Branch.__new__(Branch)
        model = self._model
        # nothing changes these objects, so both branches can share them
        never_change = (model.options, model.axis.motion, model.axis.segment, model.machine.spec)
        shared = {id(value): value for value in (*never_change, model.layer.state.configuration)}
        twin._model, twin._outputs = copy.deepcopy((model, self._outputs), shared)
        twin._samples = [sample for sample in self._samples if sample[0] >= keep_from_ns]
        twin.now_ns, twin.fired = self.now_ns, set(self.fired)
        twin.instants, twin.play = self.instants, self.play
        return twin

    @property
    def rests(self) -> bool:
        """Whether the axis is at rest."""
        return self._model.under_way is None

    def act(self, sent: Transmission) -> Branch:
        """Apply words or input levels now; return this branch."""
        self.instants = (*self.instants, self.now_ns)
        self.play += _steps_between(self._model, self.now_ns)
        if sent.words is None:
            for bit in InputBit:
                self._model.operate(bit, bool(sent.inputs & bit))
        else:
            for number, word in enumerate(sent.words):
                self._outputs[number] = word
        return self

    def advance(self, to_ns: int) -> None:
        """Run the model up to an instant, and store its images."""
        model = self._model
        while self.now_ns < to_ns:
            calm_ns = model.calm_until_ns(self._outputs) - self.now_ns
            if calm_ns > CALM_SAMPLE_NS:  # only the position changes
                step_ns = calm_ns - 1 if model.under_way is None else CALM_SAMPLE_NS
            else:
                step_ns = SAMPLE_NS
            self._sample(min(self.now_ns + step_ns, to_ns))

    def _sample(self, at_ns: int) -> None:
        """Update the model at an instant; store its image and the rules that fired."""
        self.now_ns = at_ns
        self._samples.append((at_ns, tuple(self._model.update(at_ns, self._outputs))))
        events = self._model.events
        if events:
            self.fired.update(event.name for event in events if event.kind == "rule")
            events.clear()

    def shown(self, low_ns: int, high_ns: int) -> list[ImageWords]:
        """Return the images in a window, the last image before it, and the first image after it."""
        samples = self._samples
        end = len(samples)
        while end and samples[end - 1][0] > high_ns:
            end -= 1
        first = end
        while first and samples[first - 1][0] >= low_ns:
            first -= 1
        return [words for _, words in samples[max(0, first - 1) : end + 1]]

    def forget(self, before_ns: int) -> None:
        """Drop the images before an instant except the last one; do nothing if there are fewer than 65."""
        samples, first = self._samples, 0
        while first + 1 < len(samples) and samples[first + 1][0] < before_ns:
            first += 1
        if first > 64:
            del samples[:first]

    def explains(self, read: SeenImage, timing: Timing) -> bool:
        """Advance the model past the window of a read; return whether it shows the words that were read.

        If it does and the axis rests in command mode, an uncertain position becomes the position that was
        read.
        """
        since_ns = self.instants[-1] if self.instants else self.now_ns
        drift_ns = abs(read.window.high_ns - since_ns) * timing.drift_ppm // 1_000_000
        low_ns = read.window.low_ns - timing.lag_ns - drift_ns - GRID_NS
        high_ns = read.window.high_ns + drift_ns + GRID_NS
        self.advance(high_ns + SAMPLE_NS)
        shown_words = self.shown(low_ns, high_ns)
        if not explained(shown_words, read.words, self.play):
            return False
        first = shown_words[0]
        in_command_mode = not (read.words[0] | first[0]) & MODE_CONFIG
        rests = self.rests and all(words == first for words in shown_words)
        if self.play and in_command_mode and rests:
            self._settle(read.words)
        return True

    def _settle(self, words: ImageWords) -> None:
        """Adopt the position in an image at rest, which ends the position's uncertainty."""
        self.play = 0
        model = self._model
        model.layer.state.captured = words[6] * 1000 + words[7]
        if words[2] * 1000 + words[3] != model.axis.position:
            model.axis.preset_position(words[2] * 1000 + words[3])
        model.look_again()
        self._sample(self.now_ns + 1)

    def adopt(self, words: ImageWords) -> None:
        """Adopt the encoder count and the captured value in an image."""
        model = self._model
        if not model.options.clear_status_after_config:  # otherwise they may come from an earlier scene
            model.layer.state.latches.bits |= words[0] & KEPT
        model.layer.state.captured = words[6] * 1000 + words[7]
        if model.axis.counting:
            model.axis.preset_encoder(words[4] * 1000 + words[5])
        model.look_again()
        self._sample(self.now_ns + 1)

    def state(self, since_ns: int) -> Any:
        """Return a state value; branches with the same future have equal values.

        Args:
            since_ns: status words from this instant on must also be equal.
        """
        model = self._model
        state, axis = model.layer.state, model.axis
        last_values = self._samples[-1][1][2:] if self._samples else None
        return (
            frozenset(words[:2] for at_ns, words in self._samples if at_ns >= since_ns),
            tuple(self._outputs),
            (state.latches.bits, state.configuration, state.mirror, state.command.words),
            (state.held, state.held_by_external, state.error_since_start, state.active, state.captured),
            (state.blend, repr(state.blending), state.minimum_registration),
            axis.position if axis.motion is None else _course(axis.motion, self.now_ns),
            last_values,
            _traits(model.layer.operation, self.now_ns),
        )


def _course(motion: Motion, now_ns: int) -> Any:
    """Return a value that is equal for motions with the same future, whatever their past ramps."""
    segment = motion.segment_at(max(now_ns, motion.start_ns))
    if motion.end_ns is not None or segment is not motion.segments[-1]:
        return id(motion)  # children share a motion
    travel = segment.exact_travel_at(now_ns)
    return motion.direction, motion.origin, segment.speed_at(now_ns), round(travel * FINER / PICO)


def _traits(operation: Operation | None, now_ns: int) -> tuple[Any, ...] | None:
    """Return whether an operation begins now, and its own state; None without an operation."""
    if operation is None:
        return None
    state = (
        (name, getattr(value, "__name__", value))
        for name, value in vars(operation).items()
        if name not in _OWNERS
    )
    return operation.started_ns >= now_ns, *state


def _steps_between(model: Amci3601, now_ns: int) -> int:
    """Return the steps from one tried instant to the next, plus a margin; 0 at rest."""
    motion = model.axis.motion
    return 0 if motion is None else 2 + motion.speed_at(max(now_ns, motion.start_ns)) * GRID_NS // 10**12


def explained(shown: Sequence[ImageWords], read: ImageWords, play: int = 0) -> bool:
    """Whether images explain a read: one has the same status words, and their range contains all its values.

    Args:
        play: position uncertainty in steps, which extends the range.

    >>> explained([(0, 0, 0, 10, 0, 0, 0, 0), (0, 0, 0, 14, 0, 0, 0, 0)], (0, 0, 0, 12, 0, 0, 0, 0))
    True
    """
    if not any(words[0] == read[0] and words[1] == read[1] for words in shown):
        return False
    return all(_pair_explained(shown, read, pair, play) for pair in _PAIRS)


def _pair_explained(shown: Sequence[ImageWords], read: ImageWords, pair: int, play: int) -> bool:
    """Whether images explain the value in two words, the first of which has the number `pair`."""
    high, low = read[pair], read[pair + 1]
    values = []
    for words in shown:
        if words[pair] == high and words[pair + 1] == low:
            return True
        if not words[0] & MODE_CONFIG:
            values.append(words[pair] * 1000 + words[pair + 1])
    return bool(values) and min(values) - play <= high * 1000 + low <= max(values) + play
