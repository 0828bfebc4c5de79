"""A 3601 whose recording begins in the middle of its operation, or loses sight of its state.

recording   moves, at rest, .....moves.....  an input changes while it moves  ...at rest, moves
shown       recorded |  the module, from the state that the image shows  | recorded  |  the module

At rest in command mode the input image shows position, counts, latched bits; the configuration stands in the
image of configuration mode, and nowhere else. What the recording does not show is not compared: a motion that
had begun before, one during which an input changes (its instant lies between two scans), a blend profile or a
minimum registration distance from before.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from struct import unpack

from ...io_images.amci3601 import (
    ALL_INPUTS,
    CommandLsw,
    CommandMsw,
    Configuration,
    InputBit,
    StatusLsw,
    StatusMsw,
)
from ...io_images.image import Image, signed_word
from ...io_images.thousands import join_reported
from ...runtime.loop.events import Event
from ...runtime.loop.module import Module
from ...runtime.modules.amci3601.axis_protocol import BlendProgram
from ...runtime.modules.amci3601.module import Amci3601
from ...runtime.modules.amci3601.operations.homing import Homing
from ...traces.replay import PackedTrace

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
"""Bits of word 0 that configuration mode echoes."""

NO_CONFIGURATION = "the configuration is not known yet"
NOT_AT_REST = "the axis has not been at rest yet"
INPUT_CHANGED = "an input changed during a motion, at an instant between two scans"
OLD_BLEND = "a blend profile from before ran"
COMMAND_UNSEEN = "a command came and went between two reads"
OLD_MINIMUM = "a minimum registration distance from before counted"
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
    """Return the words of `843Ch 003Ch 0 500`: decimal, or hexadecimal with an h; missing ones are 0.

    Raises:
        ValueError: one is no number of 16 bits, or there are more than eight.
    """
    if text is None:
        return None
    try:
        found = [
            int(each[:-1], 16) if each[-1] in "hH" else int(each) for each in text.replace(",", " ").split()
        ]
        return list(Image(found))
    except ValueError as error:
        raise ValueError(f"--configuration {text}: {error}; give words such as 843Ch 003Ch 0 500") from None


@dataclass(frozen=True, slots=True)
class StartState:
    """A state that was taken from an image."""

    row: int
    position: int
    configuration: Configuration | None


class ResumedModule:
    """A 3601 in the place of the one in a recording; satisfies `runtime.loop.module.Module`.

    Args:
        images: the recorded input images, 16 bytes each.
        outputs: the recorded output images.
        times: of the images, ns, ascending.
        forced: whether forces were in effect, by row.
        configuration: words that are in effect until the recording shows others; None = not known.
        exact_inputs: whether the instants at which inputs change are known.
        sampled: the recording is a client's reads, which miss short commands.

    Attributes:
        taken: the states that were taken, in order; from the next row on the module itself is shown.
        unknown: rows in which the recording is shown, by the reason.
        why: the reason of the present row; "" if the module itself is shown.
        rests: whether the present row shows all of the state, as the one before it.
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
        self._known = False
        self._blend: BlendProgram | None = None
        self._minimum = 0
        self._blend_known = self._minimum_known = False
        self.why = self._why = NOT_AT_REST
        self._before: tuple[bytes, bytes] = b"", b""  # sent and shown in the row before
        self.rests = False
        self.taken: list[StartState] = []
        self.unknown: Counter[str] = Counter()

    @property
    def configuration(self) -> Words | None:
        """The words of the configuration in effect, as far as it is known."""
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
        """Return the module's image while its state is known, else the recorded one; see `Module.update`."""
        row = self._row
        while row < self._last and self._times[row + 1] <= now_ns:
            row += 1
        is_new, self._row = row != self._row, row
        raw, sent = self._images[row], outputs.raw.tobytes()
        shown, command = words_of(raw), words_of(sent)
        if self._known and (why := self._loss(shown, command)):
            self._keep_programs()
            self._known, self._why = False, why
        self._note(shown, command)
        same = (sent, raw[:8]) == (self._before[0], self._before[1][:8])
        self.rests = is_new and same and self._at_rest(shown, command)
        if self._known:
            self.why = ""
            image = self.module.update(now_ns, outputs)
            if shown[1] & ~words_of(self._before[1])[1] & _CAPTURE and not self._exact_inputs:
                self._capture(image, shown)
            self._before = sent, raw
            return image
        if is_new:
            self.why = self._why if self._has_configuration(shown) else NO_CONFIGURATION
            self.unknown[self.why] += 1
            if self.rests:
                self._take(now_ns, shown, outputs)
            self._before = sent, raw
        self._image.raw[:] = raw
        return self._image

    def _is_unseen(self, shown: Words, before: Words, command: Words) -> bool:
        """Whether the module at rest shows something else though no command is in the recording."""
        around = command, words_of(self._before[0]), words_of(self._outputs[self._row])
        if any(words[0] or words[1] & ~_PROXIMITY for words in around) or before[0] & _MOVES:
            return False
        if self.module.layer.operation is not None:
            return False
        return [shown[0], shown[1] & ~ALL_INPUTS, *shown[2:4]] != [
            before[0],
            before[1] & ~ALL_INPUTS,
            *before[2:4],
        ]

    def _capture(self, image: Image, shown: Words) -> None:
        """Take the captured value from the recording, which does not have the instant of the capture."""
        self.module.layer.state.captured = join_reported(signed_word(shown[6]), signed_word(shown[7]))
        image[6], image[7] = shown[6], shown[7]

    def _harmless(self, command: Words) -> int:
        """Return the inputs that don't act on the present motion."""
        homes = command[0] & _HOMES or isinstance(self.module.layer.operation, Homing)
        return _CAPTURE if homes else _CAPTURE | _HOME

    def _has_configuration(self, shown: Words) -> bool:
        refused = bool(shown[0] & _CONFIG_ERROR) and not shown[0] & _CONFIGURES
        return refused or self._words is not None

    def _at_rest(self, shown: Words, command: Words) -> bool:
        """Whether the image shows all of the state: no motion, no hold, no command, no force."""
        calm = shown[0] & (_OK | _CONFIGURES | _MOVES) == _OK and not shown[1] & _BUSY_LSW
        no_command = not command[0] and not command[1] & ~_PROXIMITY
        return calm and no_command and not self._forced[self._row] and self._has_configuration(shown)

    def _take(self, now_ns: int, shown: Words, outputs: Image) -> None:
        configuration = None
        if not shown[0] & _CONFIG_ERROR:
            assert self._words is not None, "a state without configuration is not at rest"
            configuration = Configuration.from_image(Image(self._words), self.module.firmware)
        self.module.take_state(now_ns, outputs, shown, configuration)
        state = self.module.layer.state
        state.blend = self._blend
        if self._minimum_known:
            state.minimum_registration = self._minimum
        elif not shown[1] & _MINIMUM:
            self._minimum_known = True
        self._known = True
        self.taken.append(StartState(self._row, self.module.axis.position, configuration))

    def _keep_programs(self) -> None:
        """Remember what no image shows, as far as it is known."""
        state = self.module.layer.state
        self._blend, self._minimum = state.blend, state.minimum_registration
        self._blend_known &= state.blending is None

    def _note(self, shown: Words, command: Words) -> None:
        """Note the configuration, which erases programs, and the programs that are stored."""
        words = configuration_in(shown)
        if words is not None:
            self._words, self._blend, self._minimum = words, None, 0
            self._blend_known = self._minimum_known = True
        elif not command[0] & _CONFIGURES:
            if command[1] & _PROGRAMS:
                self._blend_known = self._known
            if command[1] & _STORES:
                self._minimum_known = self._known

    def _loss(self, shown: Words, command: Words) -> str:
        """Return why the state is not known from this row on; "" if it is."""
        before = words_of(self._before[1])
        if not shown[0] & _OK:
            return NO_ANSWER
        moves = (shown[0] | before[0]) & _MOVES and not (shown[0] | before[0]) & _CONFIGURES
        if (
            moves
            and not self._exact_inputs
            and (shown[1] ^ before[1]) & ALL_INPUTS & ~self._harmless(command)
        ):
            return INPUT_CHANGED
        if self._sampled and self._is_unseen(shown, before, command):
            return COMMAND_UNSEEN
        if command[0] & _CONFIGURES:
            return ""
        if command[0] & _BLEND_RUNS and not self._blend_known:
            return OLD_BLEND
        registers = command[0] & _MANUAL and (command[2] or command[3])
        return OLD_MINIMUM if registers and not self._minimum_known else ""


class ResumedOperation:
    """The slots of a recording whose 3601 was in operation before its first scan.

    Args:
        simulated: the firmware of each simulated 3601, by slot.
        forced: whether forces were in effect, by row.
        given: configuration words that were in effect at the beginning; None = those that the recording shows
            first.
        captured: the recording is a capture, so that its first scan may be in the middle of operation.
        sampled: the recording is a client's reads.

    Raises:
        ValueError: `given` is no legal configuration.
    """

    def __init__(
        self,
        recording: PackedTrace,
        simulated: Mapping[int, str],
        forced: Sequence[bool],
        given: Words | None = None,
        *,
        captured: bool = False,
        sampled: bool = False,
    ) -> None:
        self._recording, self._forced, self._sampled = recording, forced, sampled
        self._given = given if given is None else tuple(Configuration.from_image(Image(given)).to_image())
        self.slots = [
            slot.number
            for slot in (recording.slots if captured or recording.numbers[0] else ())
            if slot.number in simulated and self._begins_late(slot.number, simulated[slot.number])
        ]
        self._first = {slot: self._first_configuration(slot) for slot in self.slots}
        self.modules: dict[int, ResumedModule] = {}

    def _begins_late(self, slot: int, firmware: str) -> bool:
        fresh = bytes(Amci3601(firmware).update(0, Image()).raw)
        return self._recording.images((slot, "in"))[0] != fresh

    def _first_configuration(self, slot: int) -> tuple[int, Words] | None:
        """Return the first row that shows a configuration, and its words."""
        for row, image in enumerate(self._recording.images((slot, "in"))):
            words = configuration_in(words_of(image))
            if words is not None:
                return row, words
        return None

    def words(self, slot: int) -> Words | None:
        """Return the configuration words that a slot has at the beginning; None if they are not known."""
        first = self._first[slot]
        return self._given or (None if first is None else first[1])

    @property
    def active_high(self) -> Mapping[int, int]:
        """The inputs that are active when energized, by slot, as far as they are known."""
        return {slot: words[1] & ALL_INPUTS for slot in self.slots if (words := self.words(slot)) is not None}

    def around(self, number: int, module: Module, *, exact_inputs: bool) -> Module:
        """Return what sits in a slot in place of its module."""
        if number not in self.slots or not isinstance(module, Amci3601):
            return module
        made = ResumedModule(
            module,
            self._recording.images((number, "in")),
            self._recording.images((number, "out")),
            self._recording.times,
            self._forced,
            self.words(number),
            exact_inputs=exact_inputs,
            sampled=self._sampled,
        )
        self.modules[number] = made
        return made

    def notes(self, compared: Sequence[int]) -> list[str]:
        """Return what was assumed, and what is not compared, a sentence each.

        Raises:
            ValueError: nothing of the compared slots is known.
        """
        if compared and all(slot in self.modules and self._is_unknown(slot) for slot in compared):
            why = "; ".join(f"slot {slot}: {', '.join(self.modules[slot].unknown)}" for slot in compared)
            raise ValueError(
                f"the trace begins in the middle of operation, and nothing can be compared: {why}"
                + ("" if self._given else "; --configuration gives the words that are not in it")
            )
        return [note for slot in self.modules for note in self._notes_of(slot)]

    def _is_unknown(self, slot: int) -> bool:
        """Whether no scan of a slot is compared."""
        return sum(self.modules[slot].unknown.values()) >= len(self._recording.numbers)

    def _notes_of(self, slot: int) -> Iterator[str]:
        module, numbers = self.modules[slot], self._recording.numbers
        if self._is_unknown(slot):
            why = ", ".join(module.unknown)
            yield f"slot {slot}: the trace begins in the middle of operation; it is not compared: {why}"
            return
        taken = module.taken[0]
        yield (
            f"slot {slot}: the trace begins in the middle of operation; the module's state is that of scan "
            f"{numbers[taken.row]:,}, position {taken.position:,}{self._source(slot, taken.row)}; "
            "it is compared from the next scan on"
        )
        rows = sum(module.unknown.values())
        reasons = "; ".join(f"{count:,}: {why}" for why, count in module.unknown.items())
        yield f"slot {slot}: {rows:,} of {len(numbers):,} scans are not compared; {reasons}"

    def _source(self, slot: int, row: int) -> str:
        first = self._first[slot]
        if first is not None and first[0] < row:
            return ""
        if self._given is not None:
            return ", configuration as given"
        if first is None:
            return ", without a configuration"
        return f", configuration of scan {self._recording.numbers[first[0]]:,}, the first that it shows"
