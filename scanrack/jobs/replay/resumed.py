"""Replays a 3601 from a recording that begins during operation, or does not always show the module's state.

recording   moves, at rest, .....moves.....  an input changes while it moves  ...at rest, moves
shown       recorded |  the module, from the state that the image shows  | recorded  |  the module

At rest in command mode, the input image shows position, counts and latched bits. Only the image in
configuration mode shows the configuration. Scans with a state that the recording does not show are not
compared: a motion that had already begun, a motion during which an input changes (at an instant between two
scans), and a blend profile or minimum registration distance that was set before the recording.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from struct import unpack

from scanrack.io_images.amci3601 import (
    ALL_INPUTS,
    CommandLsw,
    CommandMsw,
    Configuration,
    InputBit,
    StatusLsw,
    StatusMsw,
)
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image, signed_word
from scanrack.io_images.thousands import join_reported
from scanrack.runtime.loop.events import Event
from scanrack.runtime.modules.amci3601.axis_protocol import BlendProgram
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.runtime.modules.amci3601.operations.homing import Homing

_MOVES = (StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW | StatusMsw.HOLD_STATE).value
_BUSY_LSW = (StatusLsw.ENC_FOLLOWER | StatusLsw.BLEND_RUNNING | StatusLsw.BLEND_ACK).value
_CONFIGURES, _CONFIG_ERROR = StatusMsw.MODE_CONFIG.value, StatusMsw.CONFIG_ERROR.value
_CAPTURE, _HOME = InputBit.CAPTURE.value, InputBit.HOME.value
_HOMES = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
_OK = StatusMsw.MODULE_OK.value
_BLEND_RUNS = (CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW).value
_MANUAL = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
_PROGRAMS, _STORES = CommandLsw.BLEND_PROGRAM.value, CommandLsw.STORE_MIN_REG.value
_PROXIMITY, _MINIMUM = CommandLsw.HOME_PROXIMITY.value, StatusLsw.MIN_REG_NONZERO.value
_ECHO = 0x1FFF
"""Mask of the bits of word 0 that configuration mode echoes."""

NO_CONFIGURATION = "the configuration is not known yet"
NOT_AT_REST = "the axis has not been at rest yet"
INPUT_CHANGED = "an input changed during a motion, at an instant between two scans"
OLD_BLEND = "a blend profile from before ran"
COMMAND_UNSEEN = "a command came and went between two reads"
OLD_MINIMUM = "a minimum registration distance from before was in effect"
NO_ANSWER = "the module did not answer"

Words = Sequence[int]


def words_of(image: bytes) -> Words:
    """Return an image as unsigned words."""
    return unpack("<8H", image)


def configuration_in(shown: Words) -> tuple[int, ...] | None:
    """Return the accepted configuration words that an input image shows; None outside configuration mode."""
    if shown[0] & (_CONFIGURES | _CONFIG_ERROR | _OK) != _CONFIGURES | _OK:
        return None
    return _CONFIGURES | shown[0] & _ECHO, *shown[1:4], 0, 0, 0, 0


def configuration_words(text: str | None) -> list[int] | None:
    """Parse words such as `843Ch 003Ch 0 500`: decimal, or hexadecimal with an h; missing words are 0.

    Raises:
        ValueError: a word is not a 16-bit number, or there are more than eight.
    """
    if text is None:
        return None
    try:
        words = text.replace(",", " ").split()
        return list(Image([int(word[:-1], 16) if word[-1] in "hH" else int(word) for word in words]))
    except ValueError as error:
        raise ValueError(f"--configuration {text}: {error}; give words such as 843Ch 003Ch 0 500") from None


@dataclass(frozen=True, slots=True)
class StartState:
    """A state that was read from an image, with which the simulated module starts."""

    row: int
    position: int  # steps
    configuration: Configuration | None  # None if the module is not configured


class ResumedModule:
    """A simulated 3601 in place of the recorded one; implements `runtime.loop.module.Module`.

    Args:
        images: the recorded input images, 16 bytes each.
        outputs: the recorded output images.
        times: times of the images, ns, ascending.
        forced: whether forces were in effect, by row.
        configuration: words in effect until the recording shows others; None = unknown.
        exact_inputs: whether the instants at which inputs change are known.
        sampled: whether the recording consists of a client's reads, which miss short commands.

    Attributes:
        starts: the states read from images, in order; from the next row, the simulated image is returned.
        unknown: number of rows in which the recorded image is returned, by reason.
        reason: the reason for the current row; "" if the simulated image is returned.
        rests: whether the current row and the previous one show the whole state.
    """

    def __init__(
        self,
        module: Amci3601,
        images: Sequence[bytes],
        outputs: Sequence[bytes],
        times: Sequence[int],
        forced: Sequence[bool],
        configuration: Words | None,
        *,
        exact_inputs: bool = False,
        sampled: bool = False,
    ) -> None:
        self.module, self._exact_inputs, self._sampled = module, exact_inputs, sampled
        self.events: list[Event] = module.events
        self._images, self._outputs, self._times, self._forced = images, outputs, times, forced
        self._words, self._last = configuration, len(times) - 1
        self._image, self._row = Image(), -1
        # the known state, which may be of an earlier row
        self._is_state_known = False
        self._blend: BlendProgram | None = None
        self._minimum = 0
        self._is_blend_known = self._is_minimum_known = False
        # of the current row
        self.reason = NOT_AT_REST
        self._reason = NOT_AT_REST  # the latest reason for an unknown state
        self._last_images: tuple[bytes, bytes] = b"", b""  # output and input image of the previous row
        self.rests = False
        self.starts: list[StartState] = []
        self.unknown: Counter[str] = Counter()

    @property
    def configuration(self) -> Words | None:
        """The configuration words in effect; None if unknown."""
        return self._words

    @property
    def linked(self) -> bool:
        """Whether the PLC reaches the module."""
        return self.module.linked

    def plc_run(self, running: bool) -> None:
        """See `Module.plc_run`."""
        self.module.plc_run(running)

    def power_cycle(self) -> None:
        """See `Module.power_cycle`."""
        self.module.power_cycle()

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Return the simulated image while the state is known, else the recorded one; see `Module.update`.

        The simulation ends at the first row with an unknown state. It starts again at a row that shows the
        whole state.
        """
        row = self._row
        while row < self._last and self._times[row + 1] <= now_ns:
            row += 1
        is_new, self._row = row != self._row, row
        raw, output_bytes = self._images[row], outputs.raw.tobytes()
        shown, command = words_of(raw), words_of(output_bytes)
        reason = self._reason_for_loss(shown, command) if self._is_state_known else ""
        if reason:
            self._keep_programs()
            self._is_state_known, self._reason = False, reason
        self._note_stored_settings(shown, command)
        last_outputs, last_inputs = self._last_images
        is_unchanged = (output_bytes, raw[:8]) == (last_outputs, last_inputs[:8])
        self.rests = is_new and is_unchanged and self._is_at_rest(shown, command)
        if self._is_state_known:
            self.reason = ""
            image = self.module.update(now_ns, outputs)
            if shown[1] & ~words_of(last_inputs)[1] & _CAPTURE and not self._exact_inputs:
                self._copy_captured_value(image, shown)
            self._last_images = output_bytes, raw
            return image
        if is_new:
            self.reason = self._reason if self._is_configuration_known(shown) else NO_CONFIGURATION
            self.unknown[self.reason] += 1
            if self.rests:
                self._start_model(now_ns, shown, outputs)
            self._last_images = output_bytes, raw
        self._image.raw[:] = raw
        return self._image

    def _is_unseen(self, shown: Words, last_shown: Words, command: Words) -> bool:
        """Return whether the module at rest shows a change for which the recording has no command."""
        # a command in any of the surrounding scans, or a motion, explains the change
        commands = command, words_of(self._last_images[0]), words_of(self._outputs[self._row])
        if any(words[0] or words[1] & ~_PROXIMITY for words in commands) or last_shown[0] & _MOVES:
            return False
        if self.module.layer.operation is not None:
            return False
        differs = [word ^ last_word for word, last_word in zip(shown[:4], last_shown, strict=False)]
        return bool(differs[0] or differs[1] & ~ALL_INPUTS or differs[2] or differs[3])

    def _copy_captured_value(self, image: Image, shown: Words) -> None:
        """Copy the captured value from the recording, which lacks the instant of the capture."""
        self.module.layer.state.captured = join_reported(signed_word(shown[6]), signed_word(shown[7]))
        image[6], image[7] = shown[6], shown[7]

    def _harmless_inputs(self, command: Words) -> int:
        """Return the inputs that do not affect the current motion."""
        is_homing = command[0] & _HOMES or isinstance(self.module.layer.operation, Homing)
        return _CAPTURE if is_homing else _CAPTURE | _HOME

    def _is_configuration_known(self, shown: Words) -> bool:
        is_unconfigured = bool(shown[0] & _CONFIG_ERROR) and not shown[0] & _CONFIGURES
        return is_unconfigured or self._words is not None

    def _is_at_rest(self, shown: Words, command: Words) -> bool:
        """Return whether the image shows the whole state: no motion, no hold, no command, no force."""
        is_idle = shown[0] & (_OK | _CONFIGURES | _MOVES) == _OK and not shown[1] & _BUSY_LSW
        no_command = not command[0] and not command[1] & ~_PROXIMITY
        return is_idle and no_command and not self._forced[self._row] and self._is_configuration_known(shown)

    def _start_model(self, now_ns: int, shown: Words, outputs: Image) -> None:
        """Start the simulated module with the state that an input image at rest shows."""
        configuration = None
        if not shown[0] & _CONFIG_ERROR:
            assert self._words is not None, "a state without configuration is not at rest"
            configuration = Configuration.from_image(Image(self._words), self.module.firmware)
        self.module.take_state(now_ns, outputs, shown, configuration)
        state = self.module.layer.state
        state.blend = self._blend
        if self._is_minimum_known:
            state.minimum_registration = self._minimum
        elif not shown[1] & _MINIMUM:
            self._is_minimum_known = True
        self._is_state_known = True
        self.starts.append(StartState(self._row, self.module.axis.position, configuration))

    def _keep_programs(self) -> None:
        """Save the blend profile and the minimum registration distance, which no image shows."""
        state = self.module.layer.state
        self._blend, self._minimum = state.blend, state.minimum_registration
        self._is_blend_known &= state.blending is None

    def _note_stored_settings(self, shown: Words, command: Words) -> None:
        """Note a configuration, which erases both programs, and whether a command stores a known program."""
        words = configuration_in(shown)
        if words is not None:
            self._words, self._blend, self._minimum = words, None, 0
            self._is_blend_known = self._is_minimum_known = True  # erased, so known to be empty
        elif not command[0] & _CONFIGURES:
            if command[1] & _PROGRAMS:
                self._is_blend_known = self._is_state_known
            if command[1] & _STORES:
                self._is_minimum_known = self._is_state_known

    def _reason_for_loss(self, shown: Words, command: Words) -> str:
        """Return the reason why the state is unknown from this row on; "" if it is known."""
        last_shown = words_of(self._last_images[1])
        if not shown[0] & _OK:
            return NO_ANSWER
        status = shown[0] | last_shown[0]
        is_moving = status & _MOVES and not status & _CONFIGURES
        changed = (shown[1] ^ last_shown[1]) & ALL_INPUTS & ~self._harmless_inputs(command)
        if is_moving and changed and not self._exact_inputs:
            return INPUT_CHANGED
        if self._sampled and self._is_unseen(shown, last_shown, command):
            return COMMAND_UNSEEN
        if command[0] & _CONFIGURES:  # erases blend profile and minimum distance, so both are known
            return ""
        if command[0] & _BLEND_RUNS and not self._is_blend_known:
            return OLD_BLEND
        # a manual move with a distance is a registration move
        registers = command[0] & _MANUAL and (command[2] or command[3])
        return OLD_MINIMUM if registers and not self._is_minimum_known else ""
