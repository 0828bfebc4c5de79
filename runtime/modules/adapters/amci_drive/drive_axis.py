"""A networked drive that serves as the command layer's axis."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration
from scanrack.io_images.drives.bits import StatusBit
from typing_extensions import override

from ....kinematics import Profile
from ...amci3601.axis_protocol import BlendProgram
from ..exchanges import ControllerState
from ..profile_driver import ProfileAxis
from ..task import Task, TaskKind
from .amci_drive_capabilities import AmciDriveCapabilities
from .amci_drive_options import AmciDriveOptions
from .driver import RESETTABLE, AmciDriver
from .units import DriveProfile, drive_profile


class DriveAxis(ProfileAxis[DriveProfile]):
    """An `Axis` that a networked drive moves."""

    driver: AmciDriver

    def __init__(self, driver: AmciDriver, options: AmciDriveOptions) -> None:
        super().__init__(driver, AmciDriveCapabilities(options))
        self._wired = options.wired

    @override
    def drive_for(self, profile: Profile) -> DriveProfile:
        return drive_profile(profile, self._start_sps)

    @override
    def note_configuration(self, configuration: Configuration) -> None:
        """Pass the inputs, encoder and starting speed to the driver."""
        self.driver.note_configuration(configuration)

    @property
    def found_home(self) -> bool:
        """Whether the last search for home ended at home."""
        return self.driver.found_home

    @property
    @override
    def ramp(self) -> int:
        """The ramp state from the drive's last status, or the expected one before the first status."""
        task = self.task
        if task is None or task.model is None:
            return super().ramp
        if self.driver.status & StatusBit.ACCELERATING:
            return 1
        return -1 if self.driver.status & StatusBit.DECELERATING else 0

    @property
    @override
    def counts(self) -> int:
        return self.driver.encoder

    @property
    @override
    def levels(self) -> int:
        """Levels of the wired inputs as last read; the others read as inactive (option unwired)."""
        first_input, second_input = self._wired
        drive_levels, configuration = self.driver.levels, self.configuration
        levels = (first_input if drive_levels & 1 else 0) | (second_input if drive_levels & 2 else 0)
        if configuration is None:
            return levels
        unwired_inputs = configuration.inputs_used & ~(first_input | second_input)
        return levels | unwired_inputs & ~configuration.active_high

    @override
    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Run a blend program as an assembled move of the drive."""
        top_sps = max(speed for _, speed, _, _ in program.segments)
        length = sum(steps for steps, _, _, _ in program.segments)
        drive = DriveProfile(self._start_sps, top_sps, 1, program.final_deceleration, program=program)
        self.driver.tasks.append(Task(TaskKind.INDEX, direction, drive, True, length))

    @override
    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Request new values for the jog in progress."""
        task = self.task
        if task is not None:
            task.drive = self.drive_for(profile)
            self.driver.changed = True

    @override
    def watch_steps(self, steps: int) -> None:
        """Store the minimum distance of the next registration move."""
        self.driver.minimum = steps - 1

    @override
    def reset_errors(self) -> None:
        """Ask the driver to reset the drive's errors."""
        driver = self.driver
        driver.clear_errors = driver.state is ControllerState.READY and bool(driver.status & RESETTABLE)
