"""The axis of a 3601, a module with the same words, or a networked drive, with PLCopen blocks as methods.

    await self.axis.move_to(4000, speed=5000, acceleration=10, deceleration=10)

Calling a method requests the command, like a rising Execute. The axis sends the command's words at the end of
this scan, or once the current command has ended. Awaiting the command waits for its end. A newer command
aborts it in the same scan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NoReturn, TypeVar, overload

from scanrack.io_images.amci3601.bits import CommandLsw, StatusMsw
from scanrack.io_images.amci3601.blend import Acceleration, BlendHeader, BlendSegment
from scanrack.io_images.amci3601.command import PresetPosition, ResetErrors, StoreMinimumRegistration
from scanrack.io_images.amci3601.configuration import Configuration
from scanrack.io_images.amci3601.moves import Direction, FindHome, Follower, Manual, Move, MoveKind, RunBlend
from scanrack.io_images.amci3601.parameters import require
from scanrack.io_images.amci3601.status import StatusView
from scanrack.io_images.amci3601.words import WORDS_3601, may_be_stepper, profile_of
from scanrack.io_images.drives.models import Model
from scanrack.io_images.drives.status import status_view
from scanrack.io_images.drives.translation import DriveTranslation, model_of
from scanrack.io_images.image import WORD_MIN, Image, signed_word
from scanrack.io_images.module_words import ModuleWords
from typing_extensions import override

from ..sequences.parts import Clock, DeclarationError, Device, Idle, Slot, Slots, Turn, words_of
from .blending import BlendProgramming
from .command import Command, Outcome
from .drive import Drive
from .drives import checked_configuration, configuration_mistake, missing_function
from .errors import ErrorId
from .kinds import (
    ABSOLUTE,
    CONFIGURE,
    GEAR_OUT,
    HALT,
    MINIMUM,
    PRESET,
    RELATIVE,
    RESET,
    RUN_BLEND,
    CommandKind,
    State,
)
from .link import Link
from .motions import Gear, Homing, Registration, Velocity
from .probe import CaptureWait
from .stop import Stop

LEAST_ROUND_TRIP_MS = 10
"""Default round trip, ms: images are exchanged at the start and end of the scan."""

_MOVING_OR_MODE = (StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW).value | WORD_MIN

_CONFIGURES = CommandLsw.ENCODER_MOVE.value
"""Word 1 while a networked drive is being configured: a bit that the axis does not use otherwise."""

CONSTANT = Acceleration.CONSTANT

AnyCommand = TypeVar("AnyCommand", bound=Command)


class Axis3601(Device):
    """An axis, which is the only writer of its module's output words.

    The ranges of speeds and rates are for a 3601; another module of the family has the ranges in its profile.

    Args:
        slot: number of the slot.
        configuration: the configuration that `configure` sends; for a networked drive, its ten words, which
            also set the format of its numbers.
        round_trip_ms: minimum wait for the module's response, ms, 10 or more. If the rack's delay for its
            backplane and adapters is longer, the axis waits that long.
        parameters_first: send the parameters of each command one round trip before its command bit, so that
            an update in two parts can't be another command. Each command begins one round trip later.

    Raises:
        ValueError: the slot is not a whole number of 1 or more, the round trip is not a whole number of 0 or
            more, or the configuration is neither a Configuration nor ten words with bit 15 of word 0 on.
    """

    def __init__(
        self,
        slot: int,
        configuration: Configuration | Sequence[int],
        *,
        round_trip_ms: int = LEAST_ROUND_TRIP_MS,
        parameters_first: bool = False,
    ) -> None:
        super().__init__()
        require("slot", slot, 1, 1_000_000)
        require("round_trip_ms", round_trip_ms, 0, 1_000_000)
        self.slot = slot
        self.configuration = checked_configuration(configuration)
        self.round_trip_ms = max(round_trip_ms, LEAST_ROUND_TRIP_MS)
        self.parameters_first = parameters_first
        self._drive = self._new_drive()
        self._words = self._drive.inputs.words
        self._limits = WORDS_3601.limits
        self._translation: DriveTranslation | None = None
        self.status: StatusView = WORDS_3601.view(self._drive.inputs)  # such as `axis.status.IN_ESTOP`

    # -- state

    @property
    def state(self) -> State:
        """The PLCopen state of the axis."""
        return self._drive.state

    @property
    def commanded(self) -> Command | None:
        """The newest command, ended or not; None before the first one."""
        return self._drive.newest

    @property
    def moving(self) -> bool:
        """Whether the module reports motion."""
        return bool(self._words[0] & _MOVING_OR_MODE > 0)  # negative in configuration mode

    @property
    def phase(self) -> int:
        """Output word 1 as sent; it changes while a blend is being programmed."""
        return self._drive.out[1]

    @property
    def trip_ns(self) -> int:
        """Time that the axis waits for the module's response, ns."""
        return self._drive.trip_ns

    @property
    def position(self) -> int:
        """Current position, steps; not valid in configuration mode."""
        return self.status.position

    @property
    def encoder(self) -> int:
        """Encoder or diagnostic feedback count; not valid in configuration mode."""
        return self.status.encoder

    @property
    def starting_speed(self) -> int:
        """Starting speed of its configuration, steps/s; 1 for a networked drive before it is attached."""
        configuration = self.configuration
        if isinstance(configuration, Configuration):
            return configuration.starting_speed
        return 1 if self._translation is None else self._translation.starting_speed

    # -- commands

    def configure(self) -> Command:
        """Configure the module and switch to command mode; the position becomes invalid [Configure3601]."""
        return self._request(Command(self.name, CONFIGURE, "configure()"), self._configuring)

    def home(
        self,
        direction: Direction,
        *,
        speed: int,
        acceleration: int,
        deceleration: int,
        proximity: Callable[[], object] | None = None,
    ) -> Command:
        """Home the axis; the command is done at the home position, which becomes 0 [MC_Home].

        Args:
            direction: first direction of the search.
            speed: 1 to 1,000,000 steps/s.
            acceleration: 1 to 2000 steps/ms/s.
            deceleration: 1 to 2000 steps/ms/s.
            proximity: returns the backplane proximity bit in each scan, for configurations with it.
        """

        def words() -> Image:
            return FindHome(direction, speed, acceleration, deceleration, limits=self._limits).to_image()

        command = Homing(self.name, f"home({_name_of(direction)})", proximity)
        return self._request(command, words)

    def move_to(
        self,
        position: int,
        *,
        speed: int,
        acceleration: int,
        deceleration: int,
        shape: Acceleration = CONSTANT,
    ) -> Command:
        """Move to a position; the command is done on arrival [MC_MoveAbsolute].

        Args:
            position: -8,388,608 to 8,388,607 steps; the current position must be valid.
            speed: 1 to 1,000,000 steps/s.
            acceleration: 1 to 2000 steps/ms/s.
            deceleration: 1 to 2000 steps/ms/s.
        """
        command = Command(self.name, ABSOLUTE, f"move_to({position})")
        move = partial(Move, MoveKind.ABSOLUTE, position, speed, acceleration, deceleration, shape)
        return self._request(command, lambda: move(limits=self._limits).to_image())

    def move_by(
        self,
        distance: int,
        *,
        speed: int,
        acceleration: int,
        deceleration: int,
        shape: Acceleration = CONSTANT,
    ) -> Command:
        """Move by a distance; the command is done on arrival [MC_MoveRelative].

        Args:
            distance: -8,388,608 to 8,388,607 steps.
            speed: 1 to 1,000,000 steps/s.
            acceleration: 1 to 2000 steps/ms/s.
            deceleration: 1 to 2000 steps/ms/s.
        """
        command = Command(self.name, RELATIVE, f"move_by({distance})")
        move = partial(Move, MoveKind.RELATIVE, distance, speed, acceleration, deceleration, shape)
        return self._request(command, lambda: move(limits=self._limits).to_image())

    @overload
    def run(
        self, speed: int, *, acceleration: int, deceleration: int, shape: Acceleration = CONSTANT
    ) -> Velocity: ...
    @overload
    def run(
        self,
        speed: int,
        *,
        acceleration: int,
        deceleration: int,
        register: int,
        shape: Acceleration = CONSTANT,
    ) -> Registration: ...
    def run(
        self,
        speed: int,
        *,
        acceleration: int,
        deceleration: int,
        register: int | None = None,
        shape: Acceleration = CONSTANT,
    ) -> Velocity | Registration:
        """Run at a speed [MC_MoveVelocity]; with `register`, stop at a distance after the external input.

        Without `register`, the run lasts until another command, such as `halt`. With `register`
        [MoveRegistration3601, firmware 3.1], the command is done once the axis is at rest.

        Args:
            speed: -1,000,000 to 1,000,000 steps/s, not 0; negative is counterclockwise.
            acceleration: 0 to 2000 steps/ms/s.
            deceleration: 0 to 2000 steps/ms/s.
            register: 1 to 8,388,607 steps after the input.
        """

        def manual() -> Image:
            """Return the output words of the move; raise a ValueError for a value out of range."""
            if speed == 0:
                raise ValueError("speed is 0; must not be 0 (negative is counterclockwise)")
            if register == 0:
                raise ValueError("registration distance is 0; must be 1 to 8388607")
            require("speed", speed, -self._limits.speed, self._limits.speed)
            direction = Direction.CW if speed > 0 else Direction.CCW
            rates, limits = (acceleration, deceleration), self._limits
            return Manual(direction, abs(speed), *rates, register or 0, shape, limits=limits).to_image()

        if register is None:
            return self._request(Velocity(self.name, f"run({speed})", self._drive), manual)
        return self._request(Registration(self.name, f"run({speed}, register={register})"), manual)

    def store_minimum(self, distance: int) -> Command:
        """Store the minimum registration distance, 0 to 8,388,607 steps [StoreMinimum3601, firmware 3.1]."""
        command = Command(self.name, MINIMUM, f"store_minimum({distance})")
        return self._request(command, lambda: StoreMinimumRegistration(distance).to_image())

    def gear(
        self, numerator: int, denominator: int = 1, *, acceleration: int = 0, deceleration: int = 0
    ) -> Gear:
        """Follow the encoder at a ratio until another command [MC_GearIn, firmware 4.1].

        Args:
            numerator: -32,767 to 32,767 steps, not 0; negative is against the encoder.
            denominator: 1 to 32,767 counts.
            acceleration: 0 to 2000 steps/ms/s; 0 jumps to the new speed.
            deceleration: 0 to 2000 steps/ms/s; 0 jumps to the new speed.
        """

        def follower() -> Image:
            direction = Direction.CW if numerator > 0 else Direction.CCW
            rates, limits = (acceleration, deceleration), self._limits
            return Follower(direction, abs(numerator), denominator, *rates, limits=limits).to_image()

        return self._request(Gear(self.name, f"gear({numerator}, {denominator})", self._drive), follower)

    def gear_out(self) -> Command:
        """Release the encoder and come to rest [MC_GearOut]; refused unless the axis is following it."""
        return self._request(Command(self.name, GEAR_OUT, "gear_out()"), Image)

    def program_blend(
        self,
        segments: Iterable[BlendSegment],
        *,
        final_deceleration: int,
        shapes: Sequence[Acceleration] = (),
        final_shape: Acceleration = CONSTANT,
    ) -> Command:
        """Program a blend profile, block by block [ProgramBlend3601].

        Args:
            segments: 2 to 16 segments.
            final_deceleration: 1 to 2000 steps/ms/s, from the last segment's speed to rest.
            shapes: acceleration type of each segment; constant by default.
            final_shape: acceleration type at the end.
        """
        path = tuple(segments)
        command = BlendProgramming(self.name, f"program_blend({len(path)} segments)")

        def blocks() -> Image:
            """Store all blocks in the command and return the first; raise a ValueError if out of range."""
            types, limits = tuple(shapes) or (CONSTANT,) * len(path), self._limits
            header = BlendHeader(types, final_deceleration, final_shape, limits=limits)
            command.fill(header, path)
            return header.to_image() if self._translation is None else command.for_drive()

        return self._request(command, blocks)

    def run_blend(self, direction: Direction) -> Command:
        """Run the programmed blend profile in a direction; the command is done at its end [RunBlend3601]."""
        command = Command(self.name, RUN_BLEND, f"run_blend({_name_of(direction)})")
        return self._request(command, lambda: RunBlend(direction).to_image())

    def halt(self) -> Command:
        """Stop the axis with its ramp; another motion may take over while it stops [MC_Halt]."""
        return self._request(Command(self.name, HALT, "halt()"), Image)

    def stop(self) -> Stop:
        """Stop the axis with its ramp; inside a `with`, all other commands are refused [MC_Stop]."""
        stop = self._request(Stop(self.name), Image)
        if stop.busy:
            self._drive.hold(stop)
        return stop

    def reset(self) -> Command:
        """Reset module and axis errors; an input that is still active causes a new error [MC_Reset]."""
        return self._request(Command(self.name, RESET, "reset()"), lambda: ResetErrors().to_image())

    def set_position(self, position: int) -> Command:
        """Set the current position, -8,388,608 to 8,388,607 steps, and make it valid [MC_SetPosition]."""
        command = Command(self.name, PRESET, f"set_position({position})")
        return self._request(command, lambda: PresetPosition(position).to_image())

    def captured(self) -> CaptureWait:
        """Return a wait for the next edge of the capture input [MC_TouchProbe].

        Its value is the position at the edge, in steps, or in encoder counts if an encoder is configured. The
        wait does not occupy the axis.
        """
        drive = self._drive
        return CaptureWait(self.name, drive.inputs.words, self.status, lambda: drive.state, drive.link)

    # -- a part of the logic

    @override
    def attach(self, slots: Slots, clock: Clock) -> None:
        """Attach to the slot's module; raise a ValueError if it or the configuration does not fit."""
        if self.slot not in slots:
            listed = ", ".join(map(str, slots)) or "none"
            self._refuse(f"slot {self.slot} is empty; modules sit in {listed}")
        slot, words = slots[self.slot], words_of(slots)[self.slot]
        model = model_of(words)
        if model is None and not may_be_stepper(words):
            self._refuse(
                f"slot {self.slot} has a {words.message}, which has neither a 3601's words nor a drive's"
            )
        mistake = configuration_mistake(self.configuration, model)
        if mistake:
            self._refuse(f"slot {self.slot}, {words.message if model is None else model.title}: {mistake}")
        self._translate(model, words, slot)
        self._drive = self._new_drive(getattr(slot, "round_trip_ms", 0))
        link = Link(self.slot, slot)
        self._drive.attach(slot.inputs, slot.outputs, clock, link, self._translation)
        self._words = slot.inputs.words

    def _translate(self, model: Model | None, words: ModuleWords, slot: Slot) -> None:
        """Set the limits and the status for the module, and the translation for a networked drive's words."""
        if model is None:
            profile = profile_of(words)
            self._translation, self._limits, self.status = None, profile.limits, profile.view(slot.inputs)
            return
        assert not isinstance(self.configuration, Configuration)
        translation = DriveTranslation(model, self.configuration)
        self._translation, self._limits = translation, translation.limits
        self.status = status_view(slot.inputs, model, translation.number)

    def _configuring(self) -> Image:
        """Return the output words that request the configuration.

        For a networked drive, the translation has the configuration. Word 1 only marks the progress of the
        handshake, when it becomes 0.
        """
        configuration = self.configuration
        if isinstance(configuration, Configuration):
            return configuration.to_image()
        return Image([signed_word(configuration[0]), _CONFIGURES])

    def _refuse(self, reason: str) -> NoReturn:
        raise DeclarationError.at(self.declared, f"{self.name}: {reason}")

    @override
    def reset_part(self) -> None:
        self._drive.reset()

    @override
    def owns(self) -> tuple[int, int, int]:
        return self.slot, -1, -1

    @override
    def turns(self) -> tuple[Turn, Turn]:
        return self._drive.judge, self._drive.send

    @override
    def idle(self) -> Idle | None:
        return self._drive.idle()

    def _new_drive(self, slot_ms: int = 0) -> Drive:
        """Return a drive that waits for the longer round trip of the axis and the slot."""
        trip_ns = max(self.round_trip_ms, slot_ms) * 1_000_000
        owner = f"{self.name or 'the axis'} of slot {self.slot} [{self.declared.spot}]"
        return Drive(trip_ns, owner, parameters_first=self.parameters_first)

    def _request(self, command: AnyCommand, words: Callable[[], Image]) -> AnyCommand:
        """Request a command if the state of the axis allows it and its parameters are valid; return it."""
        error_id, detail = self._refusal(command.kind), ""
        if error_id & ErrorId.WRONG_STATE:
            detail = f"state {self.state.name}"
        try:
            command.set_words(words())
        except ValueError as error:
            error_id, detail = error_id | ErrorId.PARAMETER, str(error)
        if not error_id and self._translation is not None:
            detail = missing_function(self._translation.model, command)
            error_id = ErrorId.NOT_AVAILABLE * bool(detail)
        if error_id:
            command.end(Outcome.ERROR, error_id, detail)
        else:
            self._drive.request(command)
        return command

    def _refusal(self, kind: CommandKind) -> int:
        """Return the ErrorID of a command that the state of the axis does not allow, else 0."""
        drive = self._drive
        wrong_state = drive.state not in kind.allowed or (kind.refused_by_stop and drive.locked)
        no_position = kind is ABSOLUTE and not drive.position_valid
        return ErrorId.WRONG_STATE * wrong_state | ErrorId.POSITION_INVALID * no_position


def _name_of(direction: Direction) -> str:
    return getattr(direction, "name", repr(direction))
