"""Motions through a client: starting, watching, stopping, and handling a line that is lost during a motion.

    start, sent once --> motion seen --> rest, confirmed --> done
                     --> no motion: the error says what is missing
    error while watching --> stop, repeated --> at rest
                                            --> not confirmed: the motor may still be moving

A late answer may describe an earlier state. After missing answers, rest is therefore confirmed only when more
reads agree than there can be late answers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar

from .link import (
    POLL_S,
    TRIES,
    BadResponseError,
    LinkError,
    NoAnswerError,
    Progress,
    RefusedError,
    StoppedError,
    UnconfirmedMotionError,
)

READS_FOR_MOTION = 4
"""Maximum number of reads, `POLL_S` apart, until a motion must be seen after an answered start."""


class MonitoringLostError(LinkError):
    """The line failed during a motion.

    Attributes:
        why: the cause, as text.
        stopped: whether a later read showed the motor at rest.
    """

    def __init__(self, why: str, *, stopped: bool, received: bytes = b"") -> None:
        outcome = (
            "the motor was stopped" if stopped else "a stop was not confirmed: THE MOTOR MAY STILL BE MOVING"
        )
        super().__init__(f"{why}; {outcome}", received)
        self.stopped = stopped
        self.why = why


def try_to_stop(stop: Callable[[], None]) -> bool:
    """Try to stop the motor; return whether `stop` confirmed that it stopped."""
    try:
        stop()
    except LinkError:
        return False
    return True


@contextmanager
def stopped_when_lost(stop: Callable[[], None]) -> Iterator[None]:
    """Stop the motor and raise MonitoringLostError if the line fails inside the block."""
    try:
        yield
    except (MonitoringLostError, StoppedError):
        raise
    except LinkError as fault:
        raise MonitoringLostError(fault.reason, stopped=try_to_stop(stop), received=fault.received) from fault


@dataclass(frozen=True, slots=True)
class ControllerView:
    """One read of a device: error bits, and the position in steps, which is final if at rest."""

    position: int
    moving: bool
    errors: int


StateType = TypeVar("StateType", bound=ControllerView)


class MotionClient(ABC, Generic[StateType]):
    """A client for a device with a motor.

    A motion raises LinkError if it was refused or possibly did not begin, and MonitoringLostError if the line
    fails after the start.

    Attributes:
        harmless: error bits that a successful motion can set.
        final: error bits that make a motion fail, even if they were set before it.
        faults: number of missing or damaged answers so far.
    """

    harmless: ClassVar[int] = 0
    final: ClassVar[int] = 0

    def __init__(self, address: int) -> None:
        self.address = address
        self.faults = 0
        self._faults_before = 0  # at the end of the previous motion
        self._errors_before = 0  # at the start of the present motion

    # -- implemented by each client ------------------------------------------------------------

    @abstractmethod
    def read(self, name: str) -> int:
        """Return a value by its name; raise ValueError for an unknown name."""

    @abstractmethod
    def start_move(self, steps: int) -> int:
        """Start a move by a signed number of steps; return its target."""

    @abstractmethod
    def look(self) -> StateType:
        """Read position, motion and errors."""

    @abstractmethod
    def reasons(self, errors: int) -> str:
        """Return the meanings of error bits and limits, as text to append to a sentence."""

    @abstractmethod
    def halt(self) -> None:
        """Stop at once; repeat the request until the device answers."""

    @abstractmethod
    def pause(self, seconds: float) -> None:
        """Wait."""

    # -- motions ------------------------------------------------------------------------------

    @property
    def position(self) -> int:
        """The position register, steps; reads it from the device."""
        return self.read("position")

    def move(self, steps: int, progress: Progress = lambda _: None) -> int:
        """Move by a signed number of steps and wait for the end; return the position.

        Raises:
            ValueError: the number of steps is 0 or too large.
            StoppedError: the move did not end at its target, or ended with an error.
        """
        check = self._prepare_check(steps)
        target = self.start_move(steps)
        state = self.watch(progress)
        with stopped_when_lost(self.stop):
            self.check_end("move", state, target)
            check(state)
            self.check_errors("move", state)
        return state.position

    def _prepare_check(self, steps: int) -> Callable[[StateType], None]:
        """Prepare a check before a move; return a function that checks the state at its end."""
        return lambda state: None

    def stop(self) -> None:
        """Stop at once, without a ramp, and check that the motor is at rest.

        Raises:
            RefusedError: the stop was answered, but the motor is still moving.
        """
        if self._await_rest(self.halt) is None:
            raise RefusedError("the stop was answered, but the motor still moves")

    def wait(self, progress: Progress = lambda _: None) -> int:
        """Wait for the end of a motion; return the position."""
        return self.watch(progress).position

    def watch(self, progress: Progress, pause_s: float = POLL_S) -> StateType:
        """Wait for the end of a motion; return the confirmed state at rest.

        Args:
            progress: called with every position.
        """
        with stopped_when_lost(self.stop):
            while (at_rest := self._read_at_rest(1, progress)) is None:
                self.pause(pause_s)
            self._faults_before = self.faults
            return at_rest

    def _read_at_rest(self, repeats: int, progress: Progress = lambda _: None) -> StateType | None:
        """Return the state at rest if further reads agree with the first one, otherwise None.

        Args:
            repeats: further reads, in addition to one for each answer that may be late.
        """
        state = self.look()
        progress(state.position)
        repeats += self.faults - self._faults_before
        if state.moving or any(self.look() != state for _ in range(repeats)):
            return None
        return state

    def _await_rest(self, first: Callable[[], None] = lambda: None) -> StateType | None:
        """Return the state at rest if one of `TRIES` reads shows it, otherwise None.

        Args:
            first: called before every read.
        """
        for _ in range(TRIES):
            first()
            if (at_rest := self._read_at_rest(0)) is not None:
                return at_rest
        return None

    def check_end(self, name: str, state: StateType, target: int) -> None:
        """Raise StoppedError if a motion has not ended at its target."""
        if state.position != target:
            message = f"the {name} ended at {state.position}, not at {target}"
            raise StoppedError(f"{message}{self.reasons(state.errors)}")

    def check_errors(self, name: str, state: StateType) -> None:
        """Raise StoppedError if a motion has ended with a new error."""
        if new_errors := state.errors & (~self._errors_before | self.final) & ~self.harmless:
            raise StoppedError(
                f"the {name} ended at {state.position} with an error{self.reasons(new_errors)}"
            )

    def begin(self, name: str, send: Callable[[], object], *, moves: bool = True) -> StateType:
        """Send a start command once, and check that the motion has begun; return the state before it.

        Args:
            moves: whether the motion must be observed; otherwise an answer is enough.

        Raises:
            RefusedError: the device refuses the start, or is already moving.
            UnconfirmedMotionError: no motion was observed.
        """
        state_before = self._await_rest()
        if state_before is None:
            raise RefusedError("a motion is already running")
        with stopped_when_lost(self.stop):
            failure = self._send_and_check(name, send, state_before, moves)
        if failure is not None:
            raise failure
        return state_before

    def _send_and_check(
        self, name: str, send: Callable[[], object], state_before: StateType, moves: bool
    ) -> LinkError | None:
        """Send a start command once; return the reason why the motion has not begun, or None if it has."""
        failure: LinkError | None = None
        try:
            send()
        except (RefusedError, NoAnswerError, BadResponseError) as fault:
            failure = fault
        state = self._await_change(state_before, READS_FOR_MOTION if moves and failure is None else 1)
        new_errors, self._errors_before = state.errors & ~state_before.errors, state.errors
        if state.moving or state.position != state_before.position:
            return None  # it has begun, even if the answer is missing or refuses a doubled request
        if failure is not None and not isinstance(failure, RefusedError):
            return UnconfirmedMotionError(
                f"{name} was not answered, and no motion was seen; it is not repeated"
            )
        if failure is None and new_errors:
            return RefusedError(f"{name} is refused{self.reasons(new_errors)}")
        if failure is None and moves:
            problem = f"no motion was seen: the position is still {state.position}"
            return UnconfirmedMotionError(f"{name} was answered, but {problem}{self.reasons(state.errors)}")
        return failure

    def _await_change(self, state_before: StateType, reads: int) -> StateType:
        """Read until the state changes, at most `reads` times; return the last state."""
        state = self.look()
        for _ in range(reads - 1):
            if state != state_before:
                break
            self.pause(POLL_S)
            state = self.look()
        return state

    def _change_address(self, value: int, send: Callable[[], object], witness: str) -> None:
        """Send a new address, and use it from then on.

        Args:
            witness: name of a value; if the answer is missing, reading this value shows which address is
                valid.
        """
        former_address = self.address
        try:
            send()
        except (NoAnswerError, BadResponseError):
            self.address = value
            try:
                self.read(witness)
            except NoAnswerError:
                self.address = former_address
                raise
        self.address = value
