"""Finds scenes in a trace, such as one captured from a real controller.

    moves, rest, moves, an input changes, rest, moves, configuration, moves
           | a scene from this rest |     | a scene  | a scene from its configuration

A trace that begins in operation is judged as it is replayed: from an image at rest that shows the module's
state until that state is lost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from scanrack.io_images.amci3601 import ALL_INPUTS, StatusMsw
from scanrack.io_images.image import WORDS, Image, signed_word
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

from ...captures.words import CAPTURED_AT, SAMPLED, is_sampled
from ...replay.replaying import forced_rows, plan_of
from ...replay.resumed import ResumedModule, configuration_in, words_of
from ...replay.resumed_operation import ResumedOperation
from ..moments import ImageWords, KnownState, PlayedScene, SeenImage, Timing, Transmission, Window

MODE_CONFIG, CONFIG_ERROR = StatusMsw.MODE_CONFIG.value, StatusMsw.CONFIG_ERROR.value
ZERO: ImageWords = (0,) * WORDS


class CapturedScenes(NamedTuple):
    """The data of a 3601 in a trace."""

    firmware: str
    scenes: list[PlayedScene]
    notes: list[str]  # defects of the trace, and assumptions
    captured_at: str  # date and time of the capture, if known


def scenes_of(
    path: Path, slot: int, timing: Timing, configuration: Sequence[int] | None = None
) -> CapturedScenes:
    """Return the firmware that a trace names, its scenes, its defects, and the assumptions.

    Each scan is a read of input words. Changed output words were sent between that scan and the next one.

    Args:
        timing: the times of the path.
        configuration: configuration words in effect at the beginning; None = the first in the trace.

    Raises:
        ValueError: it is not a trace, has no words of a 3601 in the slot, or never shows the module's state.
    """
    with open_trace(path) as trace:
        info = next((slot_info for slot_info in trace.head.slots if slot_info.number == slot), None)
        if info is None or info.module != "amci3601":
            raise ValueError(
                f"{path}: slot {slot} has no words of a 3601; scanrack import --as amci3601 makes them"
            )
        scenes = scenes_in(PackedTrace.of(trace), trace.head.metadata, slot, timing, configuration)
        scenes.notes[:0] = trace.notes
        return scenes


def scenes_in(
    recording: PackedTrace,
    facts: Mapping[str, str],
    slot: int,
    timing: Timing,
    configuration: Sequence[int] | None = None,
) -> CapturedScenes:
    """Return the scenes of a recording, see `scenes_of`.

    Args:
        facts: facts in the trace's header.
    """
    firmware = next(slot_info.firmware for slot_info in recording.slots if slot_info.number == slot) or "4.1"
    captured, sampled = facts.get("source") == "capture", is_sampled(facts)
    rows = forced_rows(plan_of(recording))
    resumed = ResumedOperation(
        recording, {slot: firmware}, rows, configuration, captured=captured, sampled=sampled
    )
    module = resumed.around(slot, Amci3601(firmware), exact_inputs=False)
    follows = module if isinstance(module, ResumedModule) else None
    since_last = sampled
    until_next = captured and facts.get("words") != SAMPLED
    scenes = _Scenes(recording, slot, follows, since_last, until_next, timing.lag_ns).found()
    notes = resumed.notes([] if scenes else [slot]) if follows else []
    if not scenes:
        scenes = [PlayedScene("all", note="the module is never configured, so nothing is known of its state")]
    return CapturedScenes(firmware, scenes, notes, facts.get(CAPTURED_AT, ""))


class _Scenes:
    """Divides the recording of a slot into scenes.

    Args:
        module: follows the recording to tell where the state is known; None if it was just powered up.
        since_last: whether changed output words may have been sent since the previous scan, as a client
            sees it.
        until_next: whether they may have been sent until the next scan, as by a PLC or in their own packet.
        lag_ns: maximum age of an image when it is read, ns.
    """

    def __init__(
        self,
        recording: PackedTrace,
        slot: int,
        module: ResumedModule | None,
        since_last: bool,
        until_next: bool,
        lag_ns: int,
    ) -> None:
        self._times, self._module = recording.times, module
        self._since_last, self._until_next, self._lag_ns = since_last, until_next, lag_ns
        self._inputs, self._outputs = recording.images((slot, "in")), recording.images((slot, "out"))
        self._configuration = ZERO
        self._in_effect = True  # whether images already follow the configuration
        self._levels = 0
        self._place: ImageWords | None = None  # the position words at a scene's first rest
        self._scenes: list[PlayedScene] = []  # scenes that have ended
        self._scene: PlayedScene | None = None

    def found(self) -> list[PlayedScene]:
        """Return the scenes, in order."""
        sent_words, known = ZERO, False
        for row, at_ns in enumerate(self._times):
            words = _words(self._outputs[row])
            seen_image = SeenImage(
                Window(self._times[row - 1] if row else 0, at_ns), _words(self._inputs[row])
            )
            was_known = known
            known, rests = self._follow(at_ns, sent_words)
            if was_known and not known:
                self._end()
            inputs = self._changed(seen_image)
            written = [Transmission(self._window(row), words)] if words != sent_words else []
            if words[0] < 0 <= sent_words[0] and not self._is_refused(row):
                self._end()
                self._scene = self._configured(row, seen_image)
                self._scene.moments += written
            elif self._scene is not None:
                self._scene.moments += inputs
                self._scene.moments += [*written, seen_image] if self._since_last else [seen_image, *written]
            if rests and not written:
                self._rest(seen_image, sent_words)
            sent_words = words
        self._end()
        return self._scenes

    def _end(self) -> None:
        """End the current scene, if there is one."""
        self._scenes += [] if self._scene is None else [self._scene]
        self._scene = None

    def _rest(self, seen: SeenImage, sent: ImageWords) -> None:
        """Begin a new scene if the axis rests in a new place, or if there is no scene."""
        if self._place not in (None, seen.words[2:4]):
            self._end()
        if self._scene is None:
            self._scene = self._resumed(seen, sent)
        self._place = seen.words[2:4]

    def _window(self, row: int) -> Window:
        """Return the window in which the words that changed in a scan were sent."""
        times, last = self._times, len(self._times) - 1
        return Window(times[max(row - self._since_last, 0)], times[min(row + self._until_next, last)])

    def _follow(self, at_ns: int, sent: ImageWords) -> tuple[bool, bool]:
        """Follow the module to a scan; return whether its state is known, and whether the scan shows all."""
        if self._module is None:
            return True, False
        self._module.update(at_ns, Image(sent))
        if self._module.rests:
            words = self._module.configuration
            self._configuration = ZERO if words is None else _signed(words)
            self._in_effect = True
        return not self._module.reason, self._module.rests

    def _resumed(self, seen: SeenImage, sent: ImageWords) -> PlayedScene:
        """Return a scene that begins with the state in an image."""
        configuration = ZERO if seen.words[0] & CONFIG_ERROR else self._configuration
        state = KnownState(seen.window, seen.words, sent, configuration, self._levels)
        return PlayedScene(f"rest at {seen.window.high_ns / 1e9:.3f} s", [state])

    def _configured(self, row: int, seen: SeenImage) -> PlayedScene:
        """Return a scene that begins with a configuration; a later image shows its input levels."""
        now = Window(seen.window.high_ns, seen.window.high_ns)
        self._place = None
        self._in_effect = entered = False
        scene = PlayedScene(f"configuration at {now.low_ns / 1e9:.3f} s", [Transmission(now, ZERO), seen])
        for image in self._inputs[row:]:
            shown_words = words_of(image)
            entered = entered or bool(shown_words[0] & MODE_CONFIG)
            accepted = configuration_in(shown_words)
            if accepted is not None:
                self._configuration = _signed(accepted)
            elif entered and not shown_words[0] & MODE_CONFIG:
                self._levels = levels_in(_words(image), self._configuration)
                if self._levels:
                    scene.moments.append(Transmission(now, None, self._levels))
                break
        return scene

    def _is_refused(self, row: int) -> bool:
        """Return whether the module refuses a configuration while it still has an earlier one."""
        entered = False
        for shown_words in map(words_of, self._inputs[row:] if any(self._configuration) else ()):
            if configuration_in(shown_words) is not None:
                return False
            if entered and not shown_words[0] & MODE_CONFIG:
                return True
            entered = entered or bool(shown_words[0] & MODE_CONFIG)
        return False

    def _changed(self, seen: SeenImage) -> list[Transmission]:
        """Return the change of input levels that an image shows, if any."""
        shows_mode = bool(seen.words[0] & MODE_CONFIG)
        self._in_effect = self._in_effect or shows_mode
        has_levels = self._in_effect and any(self._configuration) and not seen.words[0] & CONFIG_ERROR
        if shows_mode or not has_levels:
            return []
        levels = levels_in(seen.words, self._configuration)
        if levels == self._levels:
            return []
        self._levels = levels
        window = Window(seen.window.low_ns - self._lag_ns, seen.window.high_ns)
        return [Transmission(window, None, levels)]


def levels_in(shown: ImageWords, configuration: ImageWords) -> int:
    """Return the energized inputs that an image in command mode shows; unused inputs are not shown.

    >>> levels_in((0, 0b000010, 0, 0, 0, 0, 0, 0), (-31681, 0b000011, 0, 500, 0, 0, 0, 0))
    62
    """
    used, active_high = configuration[0] & ALL_INPUTS, configuration[1] & ALL_INPUTS
    return ~(shown[1] ^ active_high) & used


def _words(image: bytes) -> ImageWords:
    return _signed(words_of(image))


def _signed(words: Sequence[int]) -> ImageWords:
    return tuple(map(signed_word, words))
