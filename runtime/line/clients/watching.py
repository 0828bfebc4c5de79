"""The end of a motion as a client sees it, and the loss of the line during a motion.

    start, sent once --> a sign of motion --> rest, confirmed --> done
                       > none: the fault says what is missing
    fault while watching --> stop, repeated --> seen at rest
                                            --> not seen: it may still be moving

A late answer may describe an earlier state: after missing answers, rest is confirmed only by more
agreeing reads than there can be late answers.
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

SIGN_LOOKS = 4
"""Reads for a sign of motion after an answered start, `POLL_S` apart."""


class MonitoringLostError(LinkError):
    """A motion was started and can no longer be watched."""

    def __init__(self, why: str, *, stopped: bool, received: bytes = b"") -> None:
        outcome = (
            "the motor was stopped" if stopped else "a stop was not confirmed: THE MOTOR MAY STILL BE MOVING"
        )
        super().__init__(f"{why}; {outcome}", received)
        self.stopped = stopped  # whether the motor was read at rest afterwards
        self.why = why  # the cause, in words


def try_to_stop(stop: Callable[[], None]) -> bool:
    """Stop the motor; return whether it was seen at rest."""
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
    """One read of a controller: position in steps, final if it does not move."""

    position: int
    moving: bool
    errors: int


SeenType = TypeVar("SeenType", bound=ControllerView)


class MotionClient(ABC, Generic[SeenType]):
    """A client of a controller that moves.

    Motions raise LinkError if they were refused or are not known to have begun, and MonitoringLostError if
    the line fails after the start.
    """

    harmless: ClassVar[int] = 0  # error bits that a successful motion may leave
    final: ClassVar[int] = 0  # error bits that fail a motion even if they were set before it

    def __init__(self, address: int) -> None:
        self.address = address
        self.faults = 0
        self._faults_before = 0
        self._errors_before = 0

    # -- implemented by each client ------------------------------------------------------------

    @abstractmethod
    def read(self, name: str) -> int:
        """Return a value by its name; ValueError for an unknown one."""

    @abstractmethod
    def start_move(self, steps: int) -> int:
        """Start a move over signed steps; return its target."""

    @abstractmethod
    def look(self) -> SeenType:
        """Read position, motion and errors."""

    @abstractmethod
    def reasons(self, errors: int) -> str:
        """Return the meaning of error bits and limits, to follow a sentence."""

    @abstractmethod
    def halt(self) -> None:
        """Request an immediate stop, repeatedly until it is answered."""

    @abstractmethod
    def pause(self, seconds: float) -> None:
        """Wait."""

    # -- motions ------------------------------------------------------------------------------

    @property
    def position(self) -> int:
        """The position register, steps; reads it from the controller."""
        return self.read("position")

    def move(self, steps: int, progress: Progress = lambda _: None) -> int:
        """Move over signed steps and wait for the end; return the position.

        Raises:
            ValueError: 0, or too many steps.
            StoppedError: it ended elsewhere, or with an error; the message says why.
        """
        check = self._check_of_move(steps)
        target = self.start_move(steps)
        state = self.watch(progress)
        with stopped_when_lost(self.stop):
            self.check_end("move", state, target)
            check(state)
            self.check_errors("move", state)
        return state.position

    def _check_of_move(self, steps: int) -> Callable[[SeenType], None]:
        """Return a check of the state at the end of a move, prepared before its start."""
        return lambda seen: None

    def stop(self) -> None:
        """Stop at once, without a ramp, and check that the motor is at rest.

        Raises:
            RefusedError: the stop was answered, and the motor still moves.
        """
        if self._rest_soon(self.halt) is None:
            raise RefusedError("the stop was answered, and the motor still moves")

    def wait(self, progress: Progress = lambda _: None) -> int:
        """Wait for the end of a motion; return the position."""
        return self.watch(progress).position

    def watch(self, progress: Progress, pause_s: float = POLL_S) -> SeenType:
        """Wait for the end of a motion; return the confirmed state at rest.

        Args:
            progress: called with every position.
        """
        with stopped_when_lost(self.stop):
            while (at_rest := self._rest(1, progress)) is None:
                self.pause(pause_s)
            self._faults_before = self.faults
            return at_rest

    def _rest(self, again: int, progress: Progress = lambda _: None) -> SeenType | None:
        """Return a state at rest on which `again` + 1 reads, and one per late answer, agree; or None."""
        seen_state = self.look()
        progress(seen_state.position)
        again += self.faults - self._faults_before
        return (
            None if seen_state.moving or any(self.look() != seen_state for _ in range(again)) else seen_state
        )

    def _rest_soon(self, first: Callable[[], None] = lambda: None) -> SeenType | None:
        """Return the state at rest if one of `TRIES` attempts, each after `first`, shows it."""
        for _ in range(TRIES):
            first()
            if (at_rest := self._rest(0)) is not None:
                return at_rest
        return None

    def check_end(self, name: str, seen: SeenType, target: int) -> None:
        """Raise StoppedError if a motion has ended elsewhere."""
        if seen.position != target:
            message = f"the {name} ended at {seen.position}, not at {target}"
            raise StoppedError(f"{message}{self.reasons(seen.errors)}")

    def check_errors(self, name: str, seen: SeenType) -> None:
        """Raise StoppedError if a motion has ended with a new error."""
        if new_errors := seen.errors & (~self._errors_before | self.final) & ~self.harmless:
            raise StoppedError(f"the {name} ended at {seen.position} with an error{self.reasons(new_errors)}")

    def begin(self, name: str, send: Callable[[], object], *, moves: bool = True) -> SeenType:
        """Send a start once and check that it has begun; return the state before.

        Args:
            moves: only a visible motion proves that it has begun.

        Raises:
            RefusedError: the controller refuses it, or moves already.
            UnconfirmedMotionError: no motion was seen.
        """
        state_before = self._rest_soon()
        if state_before is None:
            raise RefusedError("a motion is under way")
        with stopped_when_lost(self.stop):
            failure = self._sent(name, send, state_before, moves)
        if failure is not None:
            raise failure
        return state_before

    def _sent(self, name: str, send: Callable[[], object], before: SeenType, moves: bool) -> LinkError | None:
        """Send a start once; return why it has not begun, None if it has."""
        failure: LinkError | None = None
        try:
            send()
        except (RefusedError, NoAnswerError, BadResponseError) as fault:
            failure = fault
        state = self._sign_of_motion(before, SIGN_LOOKS if moves and failure is None else 1)
        new_errors, self._errors_before = state.errors & ~before.errors, state.errors
        if state.moving or state.position != before.position:  # even if the request was doubled on the line
            return None
        if failure is not None and not isinstance(failure, RefusedError):
            return UnconfirmedMotionError(f"{name} was not answered, and nothing moves; it is not repeated")
        if failure is None and new_errors:
            return RefusedError(f"{name} is refused{self.reasons(new_errors)}")
        if failure is None and moves:
            problem = f"no motion was seen: the position is {state.position} as before"
            return UnconfirmedMotionError(f"{name} was answered, but {problem}{self.reasons(state.errors)}")
        return failure

    def _sign_of_motion(self, before: SeenType, looks: int) -> SeenType:
        """Read until the state changes, at most `looks` times; return the last one."""
        state = self.look()
        for _ in range(looks - 1):
            if state != before:
                break
            self.pause(POLL_S)
            state = self.look()
        return state

    def _change_address(self, value: int, send: Callable[[], object], witness: str) -> None:
        """Send a new address; after an uncertain answer keep the one with which `witness` can be read."""
        former = self.address
        try:
            send()
        except (NoAnswerError, BadResponseError):
            self.address = value
            try:
                self.read(witness)
            except NoAnswerError:
                self.address = former
                raise
        self.address = value
