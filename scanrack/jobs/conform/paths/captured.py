"""Finds scenes in a trace, such as one captured from a real controller.

    moves, rest, moves, an input changes, rest, moves, configuration, moves
           | a scene from this rest |     | a scene  | a scene from its configuration

A trace that begins in operation is judged like a replay, from an image at rest that shows the module's state
until the state becomes unknown.
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
    """Return a trace's scenes, the firmware that it names, its defects, and the assumptions made.

    Each scan is a read of input words. Changed output words were sent between that scan and the next one.

    Args:
        timing: the times of the path.
        configuration: configuration words in effect at the beginning; None for the first in the trace.

    Raises:
        ValueError: it is not a trace, has no words of a 3601 in the slot, or never shows the module's state.
    """
    with open_trace(path) as trace:
        modules = {info.number: info.module for info in trace.head.slots}
        if modules.get(slot) != "amci3601":
            raise ValueError(
                f"{path}: slot {slot} has no words of a 3601; convert them with scanrack import --as amci3601"
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
    firmware = next(info.firmware for info in recording.slots if info.number == slot) or "4.1"
    captured, sampled = facts.get("source") == "capture", is_sampled(facts)
    rows = forced_rows(plan_of(recording))
    resumed = ResumedOperation(
        recording, {slot: firmware}, rows, configuration, captured=captured, sampled=sampled
    )
    module = resumed.around(slot, Amci3601(firmware), exact_inputs=False)
    follower = module if isinstance(module, ResumedModule) else None
    until_next = captured and facts.get("words") != SAMPLED
    scenes = _SceneFinder(
        recording, slot, follower, since_last=sampled, until_next=until_next, lag_ns=timing.lag_ns
    ).scenes()
    notes = resumed.notes([] if scenes else [slot]) if follower else []
    if not scenes:
        scenes = [PlayedScene("all", note="the module is never configured, so its state is unknown")]
    return CapturedScenes(firmware, scenes, notes, facts.get(CAPTURED_AT, ""))


class _SceneFinder:
    """Divides the recording of a slot into scenes.

    Args:
        module: follows the recording and shows where the state is known; None if the module was just powered
            up.
        since_last: whether changed output words may have been sent since the previous scan, as seen by a
            client.
        until_next: whether changed output words may be sent until the next scan, as by a PLC or in a packet.
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
        self._levels = 0  # mask of the energized inputs
        self._rest_position: ImageWords | None = None  # the position words at the last rest
        self._scenes: list[PlayedScene] = []  # scenes that have ended
        self._scene: PlayedScene | None = None  # the current scene

    def scenes(self) -> list[PlayedScene]:
        """Return the scenes, in order.

        A scene ends at a configuration, at a rest in a new position, or when the state becomes unknown.
        """
        last_sent, is_known = ZERO, False
        for row, at_ns in enumerate(self._times):
            words = _words(self._outputs[row])
            window = Window(self._times[row - 1] if row else 0, at_ns)
            read = SeenImage(window, _words(self._inputs[row]))
            was_known = is_known
            is_known, rests = self._follow(at_ns, last_sent)
            if was_known and not is_known:
                self._end()
            inputs = self._changed_inputs(read)
            sent = [Transmission(self._window(row), words)] if words != last_sent else []
            begins_configuration = words[0] < 0 <= last_sent[0]  # MODE_CONFIG is the sign bit
            if begins_configuration and not self._is_refused(row):
                self._end()
                self._scene = self._configured(row, read)
                self._scene.moments += sent
            elif self._scene is not None:
                self._scene.moments += inputs
                self._scene.moments += [*sent, read] if self._since_last else [read, *sent]
            if rests and not sent:
                self._rest(read, last_sent)
            last_sent = words
        self._end()
        return self._scenes

    def _end(self) -> None:
        """End the current scene, if there is one."""
        if self._scene is not None:
            self._scenes.append(self._scene)
        self._scene = None

    def _rest(self, read: SeenImage, sent: ImageWords) -> None:
        """Begin a new scene if the axis rests at a new position, or if there is no scene."""
        if self._rest_position not in (None, read.words[2:4]):
            self._end()
        if self._scene is None:
            self._scene = self._resumed(read, sent)
        self._rest_position = read.words[2:4]

    def _window(self, row: int) -> Window:
        """Return the time window when the words that changed in a scan were sent."""
        times, last = self._times, len(self._times) - 1
        return Window(times[max(row - self._since_last, 0)], times[min(row + self._until_next, last)])

    def _follow(self, at_ns: int, sent: ImageWords) -> tuple[bool, bool]:
        """Follow the module to a scan; return whether its state is known, and whether the scan shows it."""
        if self._module is None:
            return True, False
        self._module.update(at_ns, Image(sent))
        if self._module.rests:
            words = self._module.configuration
            self._configuration = ZERO if words is None else _signed(words)
            self._in_effect = True
        return not self._module.reason, self._module.rests

    def _resumed(self, read: SeenImage, sent: ImageWords) -> PlayedScene:
        """Return a scene that begins with the state in an image."""
        configuration = ZERO if read.words[0] & CONFIG_ERROR else self._configuration
        state = KnownState(read.window, read.words, sent, configuration, self._levels)
        return PlayedScene(f"rest at {read.window.high_ns / 1e9:.3f} s", [state])

    def _configured(self, row: int, read: SeenImage) -> PlayedScene:
        """Return a scene that begins with a configuration; a later image shows its input levels."""
        now = Window(read.window.high_ns, read.window.high_ns)
        self._rest_position = None
        self._in_effect = has_entered = False  # configuration mode
        scene = PlayedScene(f"configuration at {now.low_ns / 1e9:.3f} s", [Transmission(now, ZERO), read])
        for image in self._inputs[row:]:
            shown_words = words_of(image)
            has_entered = has_entered or bool(shown_words[0] & MODE_CONFIG)
            accepted = configuration_in(shown_words)
            if accepted is not None:
                self._configuration = _signed(accepted)
            elif has_entered and not shown_words[0] & MODE_CONFIG:
                self._levels = levels_in(_words(image), self._configuration)
                if self._levels:
                    scene.moments.append(Transmission(now, None, self._levels))
                break
        return scene

    def _is_refused(self, row: int) -> bool:
        """Whether the module refuses a configuration while an earlier configuration is in effect."""
        has_entered = False  # configuration mode
        for shown_words in map(words_of, self._inputs[row:] if any(self._configuration) else ()):
            if configuration_in(shown_words) is not None:
                return False
            if has_entered and not shown_words[0] & MODE_CONFIG:
                return True
            has_entered = has_entered or bool(shown_words[0] & MODE_CONFIG)
        return False

    def _changed_inputs(self, read: SeenImage) -> list[Transmission]:
        """Return the change of input levels that an image shows, if any."""
        shows_mode = bool(read.words[0] & MODE_CONFIG)
        self._in_effect = self._in_effect or shows_mode
        has_levels = self._in_effect and any(self._configuration) and not read.words[0] & CONFIG_ERROR
        if shows_mode or not has_levels:
            return []
        levels = levels_in(read.words, self._configuration)
        if levels == self._levels:
            return []
        self._levels = levels
        window = Window(read.window.low_ns - self._lag_ns, read.window.high_ns)
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
