"""A PCL601 as the command layer's axis.

    image position = offset + counter - what the counter was moved by without motion

A preset moves the offset only. Positions are those read last; direction and
ramp follow a command from its acceptance, by the profile that the controller
is known to run.
"""

from __future__ import annotations

from ....io_images.amci3601 import Configuration, InputBit
from ...amci3601 import Capabilities
from ...amci3601.axis import BlendProgram
from ...kinematics import Profile, Rate, Shape
from ...kinematics import stop as plan_stop
from .capabilities import Pcl601Capabilities
from .driver import BOTH_SIDES, Driver, State
from .options import Options
from .task import Kind, Task
from .units import drive_for

WIRED_INPUTS = {
    1 << 2: InputBit.EXTERNAL.value,
    1 << 3: InputBit.ESTOP.value,
    1 << 4: InputBit.CAPTURE.value,
    1 << 5: InputBit.HOME.value,
}
"""Which input of the 3601 is wired to which of the controller's: 3 to 6."""

LIMITS = {
    0: 0,
    1: InputBit.CW_LIMIT.value,
    -1: InputBit.CCW_LIMIT.value,
    BOTH_SIDES: (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value,
}


class Pcl601Axis:
    """An `Axis` whose steps a PCL601 makes.

    Args:
        driver: what talks to it.
        options: what is substituted, and how it is wired.
    """

    def __init__(self, driver: Driver, options: Options) -> None:
        self.driver = driver
        self.capabilities: Capabilities = Pcl601Capabilities(options)
        self.marker_seen = False
        self._configuration: Configuration | None = None
        self._offset = 0
        self._encoder_offset = 0

    # -- what it is doing ---------------------------------------------------------------------

    @property
    def _task(self) -> Task | None:
        """The motion that the command layer knows of."""
        driver = self.driver
        if driver.cut:
            return None
        tasks = [driver.task] if driver.task is not None else []
        return next((task for task in (*tasks, *driver.tasks) if task.shown), None)

    @property
    def moving(self) -> bool:
        """Whether a motion is wanted or under way."""
        return self._task is not None

    @property
    def direction(self) -> int:
        """+1 CW, -1 CCW while moving, else 0."""
        task = self._task
        return 0 if task is None else task.direction

    @property
    def ramp(self) -> int:
        """+1 accelerating, -1 decelerating, 0 constant speed or at rest."""
        task = self._task
        if task is None or not task.ramps_up:
            return 0
        if task.stopping:
            return -1
        if task.model is None:
            return 1
        return task.model.ramp_at(max(task.model.start_ns, self.driver.master.now_ns))

    @property
    def position(self) -> int:
        """Step count as read last; 0 before there is a configuration."""
        if self._configuration is None:
            return 0
        return self._offset + self.driver.position - self.driver.rebased

    @property
    def encoder(self) -> int:
        """Encoder count as read last; the position in the place of diagnostic feedback; else 0."""
        configuration = self._configuration
        if configuration is None or not configuration.encoder_counted:
            return 0
        if configuration.diagnostic_feedback:
            return self.position + self._encoder_offset
        return (0 if self.driver.clear_encoder else self.driver.encoder) + self._encoder_offset

    @property
    def levels(self) -> int:
        """Electrical levels of the discrete inputs as read last, as a mask of `InputBit`."""
        driver, levels = self.driver, 0
        for mask, bit in WIRED_INPUTS.items():
            if driver.inputs & mask:
                levels |= bit
        return levels | LIMITS[self._limit_side]

    @property
    def _limit_side(self) -> int:
        """The limit that is on; while its side is being found out by a motion, the one left behind."""
        task = self._task
        if self.driver.limit_side == BOTH_SIDES and task is not None:
            return -task.direction
        return self.driver.limit_side

    @property
    def settled(self) -> bool:
        """Whether nothing is under way that has to be over before new words are looked at."""
        return not (self.driver.cut or self.driver.setup)

    # -- commands -----------------------------------------------------------------------------

    def configure(self, configuration: Configuration | None) -> None:
        """Take over an accepted configuration, and tell the controller."""
        self._configuration = configuration
        if configuration is not None:
            self.driver.estop_on_limits = bool(configuration.inputs_used & InputBit.ESTOP.value)
            self.driver.setup = True

    def _begin(self, task: Task) -> None:
        self.driver.tasks.append(task)

    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        """Start a move over `distance` steps (signed, not 0)."""
        direction = 1 if distance > 0 else -1
        self._begin(Task(Kind.INDEX, direction, drive_for(profile), abs(distance)))

    def step_slowly(self, now_ns: int, direction: int, speed_sps: int) -> None:
        """Start a motion of a single step at `speed_sps`."""
        self.move(now_ns, direction, Profile(speed_sps, speed_sps, 1, 1))

    def pulse(self, now_ns: int, direction: int, steps: int = 1) -> None:
        """Index by so many steps behind the command layer's back."""
        start_sps = self._start_sps
        drive = drive_for(Profile(start_sps, start_sps, 1, 1))
        self._begin(Task(Kind.INDEX, direction, drive, steps, shown=False))

    @property
    def _start_sps(self) -> int:
        return 1 if self._configuration is None else self._configuration.starting_speed

    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        """Start a motion that lasts until it is stopped."""
        self._begin(Task(Kind.SLEW, direction, drive_for(profile), registration or 0))

    def home(self, now_ns: int, direction: int, profile: Profile) -> None:
        """Search for the home switch: home type 1."""
        self._begin(Task(Kind.HOME, direction, drive_for(profile)))

    def change_speed(self, now_ns: int, profile: Profile) -> None:
        """Stop, and start again at the new speed (option respeed)."""
        task = self._task
        if task is not None:
            following = Task(Kind.SLEW, task.direction, drive_for(profile), task.steps)
            task.stopping, task.following = True, following

    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: Shape) -> None:
        """Set the mark from which the controller counts its steps."""
        task = self._task
        if task is not None:
            (task.following or task).marked = True

    def blend(self, now_ns: int, direction: int, program: BlendProgram) -> None:
        """The controller can't; the command layer has refused the profile."""
        raise NotImplementedError

    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: Shape) -> None:
        """Begin a controlled stop, at the rate that the motion has."""
        task = self._task
        if task is not None:
            task.stopping, task.following = True, None

    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: Shape) -> int:
        """Steps that a controlled stop beginning now would still make."""
        task = self._task
        if task is None or task.model is None:
            return 0
        instant_ns = max(task.model.start_ns, now_ns)
        drive = task.drive
        halt = plan_stop(task.model, instant_ns, drive.base_sps, drive.rate_spmss, Shape.CONSTANT)
        assert halt.final_steps is not None
        return halt.final_steps - task.model.steps_at(instant_ns)

    def cut(self, now_ns: int) -> None:
        """End the step output at once."""
        if self.driver.task is not None or self.driver.tasks:
            self.driver.tasks.clear()
            self.driver.cut = True

    def watch_steps(self, steps: int) -> None:
        """Nothing to ask for: everything read gets a tick."""

    def watch_counts(self, counts: int, direction: int) -> None:
        """Nothing to ask for: everything read gets a tick."""

    def watch_marker(self) -> None:
        """There is no marker input."""

    def preset_position(self, value: int) -> None:
        """Let the present position be `value`."""
        count = self.encoder
        self._offset += value - self.position
        if self._configuration is not None and self._configuration.diagnostic_feedback:
            self._encoder_offset += count - self.encoder

    def preset_encoder(self, value: int) -> None:
        """Let the present encoder count be `value`; the controller's goes back to 0."""
        configuration = self._configuration
        if configuration is not None and configuration.diagnostic_feedback:
            self._encoder_offset = value - self.position
        elif configuration is not None and configuration.quadrature_encoder:
            self.driver.clear_encoder = True
            self._encoder_offset = value

    def reset_errors(self) -> None:
        """Clear the controller's error bits."""
        self.driver.clear_errors = self.driver.state is State.READY and bool(self.driver.errors)
