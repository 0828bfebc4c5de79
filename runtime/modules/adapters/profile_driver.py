"""Driver and axis of a device that can run a 3601's profile, such as a PCL601 or a networked drive.

The device counts up to 8,000,000 steps in either direction and has an encoder. `kinematics` plans its
motions, as for a 3601.
"""

from __future__ import annotations

from typing import Protocol, TypeVar

from typing_extensions import override

from ...kinematics import AnyShape, Motion, Profile, Rate, move, register, run, stop
from .driver import Driver
from .exchanges import BIAS, Talk
from .findings import FindingKind
from .linked_axis import LinkedAxis
from .task import DriveSettings, Task, TaskKind

COUNTER_END = 8_000_000
STEPS_RESERVED = {TaskKind.SLEW: 0, TaskKind.HOME: COUNTER_END // 2}
"""Steps to the end of the counter's range that a motion without a target needs when it starts."""


class ProfileSettings(DriveSettings, Protocol):
    """Speeds and ramps of a motion in a device's terms."""

    @property
    def profile(self) -> Profile:
        """The profile that the device runs."""


Settings = TypeVar("Settings", bound=ProfileSettings)


def planned_stop(task: Task[Settings], now_ns: int) -> Motion:
    """Return the planned motion of a task whose ramp-down begins at `now_ns`."""
    assert task.model is not None
    profile = task.drive.profile
    return stop(task.model, now_ns, profile.start_sps, profile.deceleration_spmss, profile.shape)


def planned_end(task: Task[Settings], now_ns: int) -> Motion:
    """Return the planned motion of a registration move whose mark is at `now_ns`."""
    assert task.model is not None
    profile = task.drive.profile
    ramp = profile.start_sps, profile.deceleration_spmss, profile.shape
    return register(task.model, now_ns, task.steps, *ramp)


class ProfileDriver(Driver[Settings]):
    """The sequence of exchanges with a device that runs a 3601's profile."""

    def keep_counter_in_range(self, task: Task[Settings]) -> Talk:
        """Set the counter to the other end of its range if the motion would leave the range."""
        steps = task.steps if task.kind is TaskKind.INDEX else STEPS_RESERVED[task.kind]
        if abs(self.position + task.direction * steps) > COUNTER_END:
            yield from self.rebase(-task.direction * BIAS)

    @override
    def model(self, task: Task[Settings]) -> None:
        """Plan the motion from its start, with origin 0."""
        now_ns, profile = self.master.now_ns, task.drive.profile
        if task.kind is TaskKind.INDEX:
            task.model = move(now_ns, 0, task.direction * task.steps, profile)
        else:
            task.model = run(now_ns, 0, task.direction, profile)

    @override
    def watch(self, task: Task[Settings]) -> Talk:
        """Report a slew that has reached the end of the counter's range."""
        if task.kind is TaskKind.SLEW and not task.stopping and abs(self.position) > COUNTER_END:
            self.findings.add(FindingKind.OUT_OF_RANGE)
        yield from ()


class ProfileAxis(LinkedAxis[Settings]):
    """An `Axis` whose device runs a 3601's profile."""

    _encoder_offset = 0

    @property
    def counts(self) -> int:
        """Last count of the device's encoder."""
        raise NotImplementedError

    @property
    def has_encoder(self) -> bool:
        """Whether a quadrature encoder is configured."""
        return self.configuration is not None and self.configuration.quadrature_encoder

    @property
    @override
    def encoder(self) -> int:
        """Last encoder count read; without an encoder, the mirrored position or 0."""
        return self.counts + self._encoder_offset if self.has_encoder else super().encoder

    @override
    def preset_encoder(self, value: int) -> None:
        """Set the present encoder count to `value`; the device's own count does not change."""
        if self.has_encoder:
            self._encoder_offset = value - self.counts
        else:
            super().preset_encoder(value)

    @override
    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        """Return the steps that the present motion makes if it begins to stop now; 0 without a motion."""
        task = self.task
        if task is None or task.model is None:
            return 0
        instant_ns = max(task.model.start_ns, now_ns)
        stopped = planned_stop(task, instant_ns)
        assert stopped.final_steps is not None
        return stopped.final_steps - task.model.steps_at(instant_ns)
