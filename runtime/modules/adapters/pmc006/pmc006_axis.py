"""The axis of a PMC006x3s, as seen by the command layer."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.io_images.pmc006.status import Level, Status1
from typing_extensions import override

from ....controllers.pmc006.ramps import Pmc006Speeds
from ....kinematics import AnyShape, Profile, Rate
from ..exchanges import ControllerState
from ..linked_axis import LinkedAxis
from ..task import Task, TaskKind
from .driver import Pmc006Driver
from .pmc006_capabilities import FSET_INPUTS, SHARED, Pmc006Capabilities
from .pmc006_options import Pmc006Options
from .units import fitted, speeds_for

CW_LIMIT = InputBit.CW_LIMIT.value
CCW_LIMIT = InputBit.CCW_LIMIT.value


class Pmc006Axis(LinkedAxis[Pmc006Speeds]):
    """An `Axis` whose motor is driven by a PMC006x3s."""

    driver: Pmc006Driver

    def __init__(self, driver: Pmc006Driver, options: Pmc006Options) -> None:
        super().__init__(driver, Pmc006Capabilities(options))
        self._nearest = options.accel_rounding == "nearest"

    @override
    def drive_for(self, profile: Profile) -> Pmc006Speeds:
        return speeds_for(profile, nearest=self._nearest)

    @override
    def task_for(
        self, kind: TaskKind, direction: int, profile: Profile, steps: int = 0
    ) -> Task[Pmc006Speeds]:
        """Return a motion; the ramps limit the speed of a short index."""
        task = super().task_for(kind, direction, profile, steps)
        if kind is TaskKind.INDEX:
            task.drive = fitted(task.drive, steps)
        return task

    @override
    def note_configuration(self, configuration: Configuration) -> None:
        """Pass limits and edges to the driver."""
        self.driver.note_configuration(configuration)

    @property
    @override
    def levels(self) -> int:
        """Electrical levels of the discrete inputs as last read; an energized input pulls its pin low."""
        pins, levels = self.driver.levels, 0
        if not pins & Level.EXT1:
            levels |= SHARED
        if not pins & Level.EXT2:
            levels |= CW_LIMIT
        if not pins & Level.FSET:
            levels |= self._on_fset
        return levels ^ self._latched_only(levels)

    def _latched_only(self, levels: int) -> int:
        """Return limits that have stopped the motion and are no longer active; the image shows them once."""
        if self.task is None or self.task.kind is TaskKind.HOME or self.configuration is None:
            return 0
        flags = self.driver.flags
        latched = (CCW_LIMIT if flags & Status1.EXT1 else 0) | (CW_LIMIT if flags & Status1.EXT2 else 0)
        inactive_inputs = levels ^ self.configuration.active_high
        return latched & inactive_inputs

    @override
    def reset_errors(self) -> None:
        """Ask the driver to clear latched external stops that are no longer active."""
        self.driver.clear_stops = self.driver.state is ControllerState.READY and bool(self.driver.flags)

    @property
    def _on_fset(self) -> int:
        """Mask of the configured input that is wired to FSET; 0 for none."""
        inputs_used = 0 if self.configuration is None else self.configuration.inputs_used
        return next((bit.value for bit in FSET_INPUTS if inputs_used & bit.value), 0)

    @override
    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return 0: a move is held without a ramp."""
        return 0
