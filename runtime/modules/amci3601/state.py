"""The memory of a 3601 from one tick to the next.

Operations and commands change the state; this file depends on neither.
"""

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
    """A held move: its name, and its target in steps as the module counts them."""

    target: int
    name: str


@dataclass(slots=True)
class ModuleState:
    """Memory of a 3601: modes, stored programs, sampled inputs, obeyed words."""

    latches: Latches
    configuration: Configuration | None = None  # the accepted configuration, or None
    mirror: tuple[int, ...] = (0, 0, 0, 0)  # the words that configuration mode echoes
    command: CommandWords = NO_COMMAND
    running: bool = True  # whether the PLC is in run mode
    held: HeldMove | None = None  # the move that Resume continues; None after a command or an error
    held_by_external: bool = False  # whether the external input has held the last move
    error_since_start: bool = False  # whether a command error occurred since the last move was accepted
    blend: BlendProgram | None = None
    blending: BlendSession | None = None  # the blend profile in programming
    minimum_registration: int = 0  # steps of a registration move before its input counts
    active: int = 0  # active inputs, as a mask of `InputBit`
    risen: int = 0  # inputs that became active at this tick
    reported_inputs: int = 0  # inputs that the image shows as active
    captured: int = 0

    @property
    def start_sps(self) -> int:
        """Starting speed of the accepted configuration."""
        return 1 if self.configuration is None else self.configuration.starting_speed

    @property
    def in_configuration_mode(self) -> bool:
        """Whether the module is in configuration mode."""
        return bool(self.latches.bits & MODE_CONFIG)

    @property
    def locked(self) -> bool:
        """Whether only Reset Errors is accepted [chapter 6, bit 12; chapter 5, blend routine 2]."""
        return bool(self.latches.bits & (COMMAND_ERROR | INVALID_PROFILE))

    @property
    def external_active(self) -> bool:
        """Whether the external input is active."""
        return bool(self.active & EXTERNAL)

    @property
    def proximity(self) -> bool:
        """Whether the backplane home proximity bit is set; in a configuration word it is another bit."""
        return bool(self.command.lsw & PROXIMITY) and not self.command.configures

    def hold(self, held: HeldMove | None, *, by_external: bool) -> None:
        """Store the move that Resume continues."""
        self.held = held
        self.held_by_external = by_external

    def begin_move(self) -> None:
        """Reset the state of the previous move."""
        self.held = None
        self.error_since_start = False
        self.held_by_external = False

    def store_minimum(self, distance: int) -> None:
        """Store the minimum registration distance; Resume must be the first command (reading A-83)."""
        self.minimum_registration = distance
        self.held = None

    def begin_blend(self) -> BlendSession:
        """Start to program a blend profile; Resume must be the first command (reading A-83)."""
        self.blend = self.held = None
        self.blending = BlendSession()
        return self.blending

    def end_blend(self) -> None:
        """Store a complete and good blend profile."""
        if self.blending is not None:
            self.blend = self.blending.program()
            self.blending = None

    def enter_configuration_mode(self) -> None:
        """Drop a held move and a blend session, even if the request is refused (reading A-101)."""
        self.held = None
        self.blending = None
        self.latches.clear(COMMAND_ERROR)
        self.latches.bits |= MODE_CONFIG

    def erase_programs(self) -> None:
        """Erase the programs that a new configuration invalidates [chapter 4]."""
        self.blend = None
        self.minimum_registration = 0
