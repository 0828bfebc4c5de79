"""What a 3601 remembers from one tick to the next.

Operations and commands change the state; this file knows none of them.
"""

from __future__ import annotations

from dataclasses import dataclass

from ....io_images.amci3601 import CommandLsw, Configuration, InputBit
from .axis import BlendProgram
from .blend_session import BlendSession
from .command_words import CommandWords
from .latches import COMMAND_ERROR, INVALID_PROFILE, MODE_CONFIG, Latches

EXTERNAL = InputBit.EXTERNAL.value
PROXIMITY = CommandLsw.HOME_PROXIMITY.value

NO_COMMAND = CommandWords((0,) * 8)


@dataclass(frozen=True, slots=True)
class Held:
    """What Resume needs: the target of the held move, in steps as the module counts them."""

    target: int
    name: str


@dataclass(slots=True)
class ModuleState:
    """Memory of a 3601: modes, stored programs, inputs as sampled, words as obeyed.

    Attributes:
        latches: status bits that stay.
        configuration: the accepted configuration; None before there is one.
        mirror: the words that configuration mode echoes.
        command: the output words acted on last.
        running: whether the PLC is in run mode.
        held: what Resume continues; None after a command or an error in between.
        held_by_external: whether the external input has held the last move.
        error_since_start: whether a command error arose since the last move was accepted.
        blend: the stored blend profile.
        blending: the blend profile that is being programmed.
        minimum_registration: steps that a registration move makes before its input counts.
        active: inputs that are active, as a mask of `InputBit`.
        risen: inputs that became active at this tick.
        reported_inputs: inputs that the image shows as active.
    """

    latches: Latches
    configuration: Configuration | None = None
    mirror: tuple[int, ...] = (0, 0, 0, 0)
    command: CommandWords = NO_COMMAND
    running: bool = True
    held: Held | None = None
    held_by_external: bool = False
    error_since_start: bool = False
    blend: BlendProgram | None = None
    blending: BlendSession | None = None
    minimum_registration: int = 0
    active: int = 0
    risen: int = 0
    reported_inputs: int = 0
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

    def hold(self, held: Held | None, *, by_external: bool) -> None:
        """Keep what Resume continues."""
        self.held = held
        self.held_by_external = by_external

    def begin_move(self) -> None:
        """Forget what concerns the move before."""
        self.held = None
        self.error_since_start = False
        self.held_by_external = False

    def store_minimum(self, distance: int) -> None:
        """Store the minimum registration distance; Resume has to be the first command (reading A-83)."""
        self.minimum_registration = distance
        self.held = None

    def begin_blend(self) -> BlendSession:
        """Start the programming of a blend profile; Resume has to be the first command (reading A-83)."""
        self.blend = self.held = None
        self.blending = BlendSession()
        return self.blending

    def end_blend(self) -> None:
        """Store the blend profile that has been programmed, if it is complete and good."""
        if self.blending is not None:
            self.blend = self.blending.program()
            self.blending = None

    def enter_configuration_mode(self) -> None:
        """Drop a held move and a blend session; a refused request ends here, too (reading A-101)."""
        self.held = None
        self.blending = None
        self.latches.clear(COMMAND_ERROR)
        self.latches.bits |= MODE_CONFIG

    def erase_programs(self) -> None:
        """Erase what programming the configuration erases [chapter 4]."""
        self.blend = None
        self.minimum_registration = 0
