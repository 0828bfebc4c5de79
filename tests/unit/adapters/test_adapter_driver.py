"""The scripts of a driver by themselves: what they wait for, and in which states they act."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from typing import Any, NamedTuple

import pytest
from scanrack.runtime import LineFormat
from scanrack.runtime.line.master import LineTiming, Reply, Step
from scanrack.runtime.modules.adapters.driver import REBIAS_BELOW, Driver
from scanrack.runtime.modules.adapters.exchanges import BIAS, ControllerState, Talk
from scanrack.runtime.modules.adapters.findings import Finding, FindingKind, Findings
from scanrack.runtime.modules.adapters.task import Task, TaskKind


class Speed(NamedTuple):
    """Settings of a motion."""

    max_sps: int


DRIVE = Speed(500)


class Noted(Driver[Speed]):
    """A driver without a line: it notes what it is asked for, and is busy for so many looks."""

    def __init__(self, busy_looks: int = 0, positions: Iterable[int] = ()) -> None:
        super().__init__(LineTiming(LineFormat(9600), 0, 0))
        self.asked: list[str] = []
        self.looks = busy_looks
        self.positions = iter(positions)

    def stop(self) -> Talk:
        self.asked.append("stop")
        yield from ()

    def slow_down(self, task: Task[Speed]) -> Talk:
        self.asked.append("slow down")
        yield from ()

    def read_status(self) -> Talk:
        self.asked.append("status")
        self.busy, self.looks = self.looks > 0, self.looks - 1
        yield from ()

    def ask_position(self) -> Generator[Step, Reply | None, int]:
        self.asked.append("position")
        yield from ()
        return next(self.positions, self.position)

    def read_inputs(self) -> Talk:
        self.asked.append("inputs")
        yield from ()

    def write_position(self, position: int) -> Talk:
        self.asked.append(f"position := {position}")
        yield from ()

    def forget(self) -> None:
        self.asked.append("forget")


def done(talk: Talk) -> list[Any]:
    """Carry a script out; return what it has yielded."""
    return list(talk)


def test_a_stop_waits_for_standstill_before_the_position_is_read() -> None:
    driver = Noted(busy_looks=2)
    done(driver.stop_and_read_status())
    assert driver.asked == ["stop", "status", "status", "status", "position"]


def test_what_is_left_behind_a_mark_is_counted_from_standstill() -> None:
    driver = Noted(busy_looks=2, positions=[1000, 1030])
    task = Task(TaskKind.SLEW, 1, DRIVE, False, steps=100)
    done(driver.stop_and_index(task))
    assert driver.asked == ["position", "slow down", "status", "status", "status", "position"]
    assert task.stopping
    assert task.following == Task(
        TaskKind.INDEX, 1, DRIVE, False, steps=70
    )  # 30 of 100 steps went into the stop


@pytest.mark.parametrize("steps", [29, 30])
def test_nothing_is_left_behind_a_mark_when_the_stop_has_used_it_up(steps: int) -> None:
    driver = Noted(positions=[1000, 970])
    task = Task(TaskKind.SLEW, -1, DRIVE, False, steps=steps)
    done(driver.stop_and_index(task))
    assert task.following is None


@pytest.mark.parametrize(
    ("state", "position", "busy_looks", "moved"),
    [
        (ControllerState.READY, REBIAS_BELOW - 1, 0, True),
        (ControllerState.READY, 1 - REBIAS_BELOW, 0, True),
        (ControllerState.READY, REBIAS_BELOW, 0, False),
        (ControllerState.READY, -REBIAS_BELOW, 0, False),
        (ControllerState.READY, 0, 9, False),
        (ControllerState.PRESENT, 0, 0, False),  # nobody has configured it: its counter is not ours
        (ControllerState.PRESENT, 0, 9, False),
    ],
)
def test_the_counter_is_moved_away_from_0_only_when_ready_and_at_rest(
    state: ControllerState, position: int, busy_looks: int, moved: bool
) -> None:
    driver = Noted(busy_looks)
    driver.state, driver.position = state, position
    done(driver._poll_at_rest())
    assert driver.asked == ["status", "position", "inputs", *([f"position := {BIAS}"] if moved else [])]
    assert driver.rebased == (BIAS - position if moved else 0)


@pytest.mark.parametrize(
    ("state", "strayed"), [(ControllerState.READY, True), (ControllerState.PRESENT, False)]
)
@pytest.mark.parametrize("busy", [False, True])
def test_what_moves_untold_has_strayed_when_it_is_ready(
    state: ControllerState, strayed: bool, busy: bool
) -> None:
    driver = Noted(busy_looks=int(busy), positions=[] if busy else [BIAS + 7])
    driver.state, driver.position = state, BIAS
    done(driver._poll_at_rest())
    assert driver.findings.take() == [Finding(FindingKind.STRAYED)] * strayed


def test_what_rests_has_not_strayed() -> None:
    driver = Noted(positions=[BIAS])
    driver.state, driver.position = ControllerState.READY, BIAS
    done(driver._poll_at_rest())
    assert not driver.findings.take()


def test_a_lost_link_forgets_every_motion_that_was_to_follow() -> None:
    driver = Noted()
    index = Task(TaskKind.INDEX, 1, DRIVE, False, steps=70)
    driver.task, driver.cut = index, True
    driver.tasks += [index, index]
    driver._reset_after_loss()
    assert (driver.task, driver.tasks, driver.cut) == (None, [], False)
    assert driver.asked == ["forget"]


def test_findings_are_taken_by_kind_and_once() -> None:
    findings = Findings()
    findings.add(FindingKind.STRAYED)
    findings.complain(1 << 12, "refused")
    findings.add(FindingKind.STRAYED)
    findings.complain(0, "too hot")
    findings.add(FindingKind.POWER_LOST)
    assert [(each.kind, each.text) for each in findings.take()] == [
        (FindingKind.POWER_LOST, ""),
        (FindingKind.COMPLAINT, "refused"),
        (FindingKind.COMPLAINT, "too hot"),
        (FindingKind.STRAYED, ""),
    ]
    assert not findings.take()
