"""The command layer's view of a device as an axis; this part is shared by all devices.

    image position = offset + counter - change of the counter that was made without motion

A preset changes the offset only. The position is from the latest read. Direction and ramp are computed from
the accepted command and the profile that the device runs.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Generic

from scanrack.io_images.amci3601 import Configuration, InputBit

from ...kinematics import AnyShape, Profile, Rate
from ..amci3601 import Capabilities
from ..amci3601.axis_protocol import BlendProgram
from .capabilities import RowCapabilities
from .driver import Driver
from .task import Drive, Task, TaskKind

CAPTURE = InputBit.CAPTURE.value


class LinkedAxis(Generic[Drive]):
    """An `Axis` whose motor is driven by a device.

    Attributes:
        substitutions: substitutions that have not been reported yet.
    """

    def __init__(self, driver: Driver[Drive], capabilities: RowCapabilities[Any]) -> None:
        self.driver = driver
        self.capabilities: Capabilities = capabilities
        self.substitutions = capabilities.new_substitutions
        self.configuration: Configuration | None = None
        self.marker_seen = False
        self._offset = 0  # of the position from the device's counter, see `position`
        self._count_offset = 0  # the mirrored encoder count less the position

    # -- implemented for each device -----------------------------------------------------------

    def drive_for(self, profile: Profile) -> Drive:
        """Return a profile in the device's terms."""
        raise NotImplementedError

    def task_for(self, kind: TaskKind, direction: int, profile: Profile, steps: int = 0) -> Task[Drive]:
        """Return a motion in the device's terms."""
        return Task(kind, direction, self.drive_for(profile), profile.has_ramps, steps)

    @property
    def levels(self) -> int:
        """Electrical levels of the discrete inputs as last read, as a mask of `InputBit`."""
        raise NotImplementedError

    def note_configuration(self, configuration: Configuration) -> None:
        """Pass a configuration to the driver in the device's terms."""
        raise NotImplementedError

    # -- present activity ---------------------------------------------------------------------

    @property
    def task(self) -> Task[Drive] | None:
        """The motion that the command layer sees, until a reply shows that it has ended."""
        return next((task for task in self._tasks if task.shown), None)

    @property
    def _tasks(self) -> tuple[Task[Drive], ...]:
        """All motions, the present one first."""
        driver = self.driver
        return tuple(driver.tasks) if driver.task is None else (driver.task, *driver.tasks)

    @property
    def moving(self) -> bool:
        """Whether a motion is requested or in progress, or a hard stop has not been confirmed yet."""
        return self.driver.cut or self.task is not None

    @property
    def direction(self) -> int:
        """+1 CW, -1 CCW while moving, else 0."""
        task = self.task
        return 0 if task is None else task.direction

    @property
    def ramp(self) -> int:
        """+1 accelerating, -1 decelerating, 0 constant speed or at rest."""
        task = self.task
        if task is None or not task.ramps_up:
            return 0
        if task.stopping:
            return -1
        if task.model is None:
            return 1
        return task.model.ramp_at(max(task.model.start_ns, self.driver.master.now_ns))

    @property
    def position(self) -> int:
        """Last step count read; 0 without a configuration."""
        if self.configuration is None:
            return 0
        return self._offset + self.driver.position - self.driver.rebased

    @property
    def encoder(self) -> int:
        """With diagnostic feedback, the position as a substitute; otherwise 0."""
        configuration = self.configuration
        if configuration is None or not configuration.diagnostic_feedback:
            return 0
        return self.position + self._count_offset

    @property
    def settled(self) -> bool:
        """Whether new words may act: no hard stop, configuration or single pulse is in progress."""
        return not (self.driver.cut or self.driver.setup) and all(task.shown for task in self._tasks)

    # -- commands -----------------------------------------------------------------------------

    def configure(self, configuration: Configuration | None) -> None:
        """Adopt an accepted configuration, and configure the controller."""
        self.configuration = configuration
        if configuration is not None:
            captures, active_high = configuration.inputs_used & CAPTURE, configuration.active_high & CAPTURE
            self.driver.capture_level = bool(active_high) if captures else None
            self.note_configuration(configuration)
            self.driver.setup = True

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""
        direction = 1 if distance > 0 else -1
        self.driver.tasks.append(self.task_for(TaskKind.INDEX, direction, profile, abs(distance)))

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a single step at `speed_sps`."""
        self.move(now_ns, direction, Profile(speed_sps, speed_sps, 1, 1))

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Index by a number of steps without showing a motion."""
        start_sps = self._start_sps
        task = self.task_for(TaskKind.INDEX, direction, Profile(start_sps, start_sps, 1, 1), steps)
        task.shown = False
        self.driver.tasks.append(task)

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped."""
        self.driver.tasks.append(self.task_for(TaskKind.SLEW, direction, profile, registration or 0))

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Search for the home switch with the device's own routine."""
        self.driver.tasks.append(self.task_for(TaskKind.HOME, direction, profile))

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Stop, and restart at the new speed."""
        task = self.task
        if task is not None:
            task.following = self.task_for(TaskKind.SLEW, task.direction, profile, task.steps)
            task.stopping = True

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Set the mark from which the device counts the remaining steps."""
        task = self.task
        if task is not None:
            (task.following or task).marked = True

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Index segment by segment, with a stop between segments (option blend)."""
        tasks: list[Task[Drive]] = []
        for length, speed, rate, shape in program.segments:
            is_last = len(tasks) + 1 == len(program.segments)
            end_rate = program.final_deceleration if is_last else rate
            profile = Profile(self._start_sps, speed, rate, end_rate, shape)
            tasks.append(self.task_for(TaskKind.INDEX, direction, profile, length))
        for task, following in pairwise(tasks):
            task.following = following
        self.driver.tasks.append(tasks[0])

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Begin a controlled stop at the rate of the motion."""
        task = self.task
        if task is not None:
            task.stopping, task.following = True, None

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the number of steps of a controlled stop that begins now."""
        raise NotImplementedError

    def cut(self, now_ns: int) -> None:
        """Send a hard stop before anything else; `moving` is true until a read shows the axis at rest."""
        self.driver.cut = True

    def watch_steps(self, steps: int) -> None:
        """Do nothing: every read causes a tick."""

    def watch_counts(self, counts: int, direction: int) -> None:
        """Do nothing: every read causes a tick."""

    def watch_marker(self) -> None:
        """Do nothing, because the marker is not wired."""

    def preset_position(self, value: int) -> None:
        """Set the present position to `value`; the mirrored encoder count does not change."""
        shift = value - self.position
        self._offset += shift
        self._count_offset -= shift

    def preset_encoder(self, value: int) -> None:
        """Set the mirrored encoder count to `value`."""
        self._count_offset = value - self.position

    def reset_errors(self) -> None:
        """Do nothing, because the axis has no errors."""

    @property
    def _start_sps(self) -> int:
        return 1 if self.configuration is None else self.configuration.starting_speed
