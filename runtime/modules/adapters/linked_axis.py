"""A driven controller as the command layer's axis: the part that all controllers share.

    image position = offset + counter - steps by which the counter was set without motion

A preset moves the offset only. Positions are from the latest read; direction and
ramp follow a command from its acceptance, by the profile that the controller
is known to run.
"""

from __future__ import annotations

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
    """An `Axis` whose steps a controller makes.

    Args:
        capabilities: the limits of the controller.
    """

    def __init__(self, driver: Driver[Drive], capabilities: RowCapabilities[Any]) -> None:
        self.driver = driver
        self.capabilities: Capabilities = capabilities
        self.substitutions = capabilities.news  # substitutions that have not been reported yet
        self.configuration: Configuration | None = None
        self.marker_seen = False
        self._offset = 0
        self._count_offset = 0

    # -- implemented for each controller -------------------------------------------------------

    def drive_for(self, profile: Profile) -> Drive:
        """Return a profile in the controller's terms."""
        raise NotImplementedError

    def task_for(self, kind: TaskKind, direction: int, profile: Profile, steps: int = 0) -> Task[Drive]:
        """Return a motion in the controller's terms."""
        drive = self.drive_for(profile)
        return Task(kind, direction, drive, profile.has_ramps, steps)

    @property
    def levels(self) -> int:
        """Electrical levels of the discrete inputs as last read, as a mask of `InputBit`."""
        raise NotImplementedError

    def note_configuration(self, configuration: Configuration) -> None:
        """Pass a configuration to the driver in the controller's terms."""
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
        """Whether new words may act: no hard stop, no configuration and no single pulse is in progress."""
        return not (self.driver.cut or self.driver.setup) and all(task.shown for task in self._tasks)

    # -- commands -----------------------------------------------------------------------------

    def configure(self, configuration: Configuration | None) -> None:
        """Adopt an accepted configuration, and configure the controller."""
        self.configuration = configuration
        if configuration is not None:
            uses_it, active_high = configuration.inputs_used & CAPTURE, configuration.active_high & CAPTURE
            self.driver.captures = bool(active_high) if uses_it else None
            self.note_configuration(configuration)
            self.driver.setup = True

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""
        direction = 1 if distance > 0 else -1
        self.driver.tasks.append(self.task_for(TaskKind.INDEX, direction, profile, abs(distance)))

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a motion of a single step at `speed_sps`."""
        self.move(now_ns, direction, Profile(speed_sps, speed_sps, 1, 1))

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Index by a number of steps without showing a motion."""
        start_sps = 1 if self.configuration is None else self.configuration.starting_speed
        task = self.task_for(TaskKind.INDEX, direction, Profile(start_sps, start_sps, 1, 1), steps)
        task.shown = False
        self.driver.tasks.append(task)

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped."""
        self.driver.tasks.append(self.task_for(TaskKind.SLEW, direction, profile, registration or 0))

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Search for the home switch, by the controller's own routine."""
        self.driver.tasks.append(self.task_for(TaskKind.HOME, direction, profile))

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Stop, and restart at the new speed."""
        task = self.task
        if task is not None:
            task.following = self.task_for(TaskKind.SLEW, task.direction, profile, task.steps)
            task.stopping = True

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Set the mark from which the controller counts its steps."""
        task = self.task
        if task is not None:
            (task.following or task).marked = True

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """Index segment by segment, with a stop in between (option blend)."""
        start_sps = 1 if self.configuration is None else self.configuration.starting_speed
        next_task: Task[Drive] | None = None
        last_index = len(program.segments) - 1
        for index, (length, speed, rate, shape) in reversed(list(enumerate(program.segments))):
            end_rate = program.final_deceleration if index == last_index else rate
            profile = Profile(start_sps, speed, rate, end_rate, shape)
            task = self.task_for(TaskKind.INDEX, direction, profile, length)
            task.following, next_task = next_task, task
        assert next_task is not None
        self.driver.tasks.append(next_task)

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        """Begin a controlled stop, at the rate of the motion."""
        task = self.task
        if task is not None:
            task.stopping, task.following = True, None

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the steps that a controlled stop beginning now would still make."""
        raise NotImplementedError

    def cut(self, now_ns: int) -> None:
        """Send a hard stop before anything else; `moving` lasts until the axis has been read at rest."""
        self.driver.cut = True

    def watch_steps(self, steps: int) -> None:
        """Do nothing: every read causes a tick."""

    def watch_counts(self, counts: int, direction: int) -> None:
        """Do nothing: every read causes a tick."""

    def watch_marker(self) -> None:
        """Do nothing: the marker is not wired."""

    def preset_position(self, value: int) -> None:
        """Set the present position to `value`; a count that copies the position is not changed."""
        shift = value - self.position
        self._offset += shift
        self._count_offset -= shift

    def preset_encoder(self, value: int) -> None:
        """Set the count that copies the position to `value`."""
        self._count_offset = value - self.position

    def reset_errors(self) -> None:
        """Do nothing: the axis has no errors."""
