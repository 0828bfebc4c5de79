"""The state of a 3601 that persists from tick to tick and is changed by commands and operations."""

from __future__ import annotations

from scanrack.io_images.amci3601 import CommandLsw, Configuration, InputBit
from scanrack.io_images.dataclass import dataclass

from .axis_protocol import BlendProgram
from .blend_session import BlendSession
from .command_words import CommandWords
from .latches import COMMAND_ERROR, INVALID_PROFILE, MODE_CONFIG, Latches

EXTERNAL = InputBit.EXTERNAL.value
PROXIMITY = CommandLsw.HOME_PROXIMITY.value

NO_COMMAND = CommandWords((0,) * 8)


@dataclass(frozen=True, slots=True)
class HeldMove:
    """A held move."""

    target: int  # in the module's steps
    name: str


@dataclass(slots=True)
class ModuleState:
    """Modes, stored programs, sampled inputs and obeyed words of a 3601."""

    latches: Latches
    configuration: Configuration | None = None  # the accepted configuration, or None
    mirror: tuple[int, ...] = (0, 0, 0, 0)  # the words that configuration mode echoes
    command: CommandWords = NO_COMMAND  # the obeyed words
    running: bool = True  # whether the PLC is in run mode
    held: HeldMove | None = None  # the move that Resume continues; None after a command or an error
    held_by_external: bool = False  # whether the external input held the last move
    error_since_start: bool = False  # whether a command error occurred since the last move was accepted
    blend: BlendProgram | None = None  # the stored blend profile
    blending: BlendSession | None = None  # the programming of a blend profile
    minimum_registration: int = 0  # steps of a registration move during which its input is ignored
    active: int = 0  # active inputs, as a mask of `InputBit`
    risen: int = 0  # mask of inputs that became active at this tick
    reported_inputs: int = 0  # mask of inputs that the image shows as active
    captured: int = 0  # last captured position or encoder count

    @property
    def start_sps(self) -> int:
        """Starting speed of the accepted configuration, steps/s."""
        return 1 if self.configuration is None else self.configuration.starting_speed

    @property
    def in_configuration_mode(self) -> bool:
        """Whether the module is in configuration mode."""
        return bool(self.latches.bits & MODE_CONFIG)

    @property
    def locked(self) -> bool:
        """Whether the module accepts only Reset Errors [chapter 6, bit 12; chapter 5, blend routine 2]."""
        return bool(self.latches.bits & (COMMAND_ERROR | INVALID_PROFILE))

    @property
    def external_active(self) -> bool:
        """Whether the external input is active."""
        return bool(self.active & EXTERNAL)

    @property
    def proximity(self) -> bool:
        """Whether the backplane home proximity bit is set; configuration words do not contain it."""
        return bool(self.command.lsw & PROXIMITY) and not self.command.configures

    def hold(self, held_move: HeldMove | None, *, by_external: bool) -> None:
        """Store the move that Resume continues."""
        self.held = held_move
        self.held_by_external = by_external

    def begin_move(self) -> None:
        """Reset the state of the previous move."""
        self.held = None
        self.error_since_start = False
        self.held_by_external = False

    def store_minimum(self, distance: int) -> None:
        """Store the minimum registration distance, and drop a held move (reading A-83)."""
        self.minimum_registration = distance
        self.held = None

    def begin_blend(self) -> BlendSession:
        """Start programming a blend profile, and drop a held move (reading A-83)."""
        self.blend = self.held = None
        self.blending = BlendSession()
        return self.blending

    def end_blend(self) -> None:
        """End the programming, and store the blend profile if it is complete and valid."""
        if self.blending is not None:
            self.blend = self.blending.program()
            self.blending = None

    def enter_configuration_mode(self) -> None:
        """Enter the mode, and drop a held move and a blend session (reading A-101)."""
        self.held = None
        self.blending = None
        self.latches.clear(COMMAND_ERROR)
        self.latches.bits |= MODE_CONFIG

    def erase_programs(self) -> None:
        """Erase the programs that a new configuration invalidates [chapter 4]."""
        self.blend = None
        self.minimum_registration = 0
