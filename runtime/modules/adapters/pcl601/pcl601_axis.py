"""The axis of a PCL601, as seen by the command layer."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, InputBit
from typing_extensions import override

from ....kinematics import Profile
from ..exchanges import ControllerState
from ..profile_driver import ProfileAxis
from ..task import TaskKind
from .driver import BOTH_SIDES, Pcl601Driver
from .pcl601_capabilities import Pcl601Capabilities, polls_mark
from .pcl601_options import Pcl601Options
from .units import Drive, drive_for

WIRED_INPUTS = {
    1 << 2: InputBit.EXTERNAL.value,
    1 << 3: InputBit.ESTOP.value,
    1 << 4: InputBit.CAPTURE.value,
    1 << 5: InputBit.HOME.value,
}
"""The device's inputs 3 to 6, with the 3601's inputs that are wired to them."""

LIMIT_INPUTS = {1 << 0: InputBit.CW_LIMIT.value, 1 << 4: InputBit.CCW_LIMIT.value}
"""The device's inputs 1 and 5; option limit_sense wires the end limits to them."""

LIMITS = {
    0: 0,
    1: InputBit.CW_LIMIT.value,
    -1: InputBit.CCW_LIMIT.value,
    BOTH_SIDES: (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value,
}
"""The 3601's active limits by `limit_side`."""


class Pcl601Axis(ProfileAxis[Drive]):
    """An `Axis` whose motor is driven by a PCL601."""

    driver: Pcl601Driver

    def __init__(self, driver: Pcl601Driver, options: Pcl601Options) -> None:
        super().__init__(driver, Pcl601Capabilities(options))
        self._options = options
        self._limits_on_inputs = options.limit_sense == "inputs"

    @override
    def drive_for(self, profile: Profile) -> Drive:
        return drive_for(profile)

    @override
    def note_configuration(self, configuration: Configuration) -> None:
        self.driver.estop_on_limits = bool(configuration.inputs_used & InputBit.ESTOP.value)
        self.driver.has_proximity = configuration.backplane_proximity
        self.driver.captures_encoder = configuration.quadrature_encoder

    @property
    @override
    def counts(self) -> int:
        return 0 if self.driver.clear_encoder else self.driver.encoder

    @property
    @override
    def levels(self) -> int:
        """Levels of the inputs as last read; a limit without an input is known only by its side."""
        wired_inputs, levels = WIRED_INPUTS, LIMITS[self._limit_side]
        if self._limits_on_inputs:
            wired_inputs, levels = WIRED_INPUTS | LIMIT_INPUTS, 0
        for mask, bit in wired_inputs.items():
            if self.driver.inputs & mask:
                levels |= bit
        return levels

    @property
    def _limit_side(self) -> int:
        """The side of the active limit; an unknown limit counts as behind the motion."""
        task = self.task
        if self.driver.limit_side == BOTH_SIDES and task is not None:
            return -task.direction
        return self.driver.limit_side

    @override
    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Stop, and restart at the new speed; in homing, set the proximity output instead."""
        task = self.task
        if task is not None and task.kind is TaskKind.HOME:
            task.marked = True
        else:
            super().change_speed(now_ns, profile)

    @override
    def watch_steps(self, steps: int) -> None:
        """Choose whether the driver polls the input of the next registration move."""
        assert self.configuration is not None
        self.driver.polls_marks = polls_mark(self.configuration, steps - 1, self._options)

    @override
    def preset_encoder(self, value: int) -> None:
        """Set the present encoder count to `value`, and the device's own count to 0."""
        if self.has_encoder:
            self.driver.clear_encoder = True
        super().preset_encoder(value)

    @override
    def reset_errors(self) -> None:
        """Ask the driver to clear the device's error bits."""
        self.driver.clear_errors = self.driver.state is ControllerState.READY and bool(self.driver.errors)
