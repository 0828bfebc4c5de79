"""A session: scans that can be paused, stepped and run at any speed, with operator actions between them.

    run:     scan scan scan | pause ...................... | continue: scan scan
    actions       ^    ^            ^ each takes effect before the next scan

The session runs in the thread of the scan loop. While scans run, the tap checks for actions after every scan;
during a pause the session waits for them.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

from ..loop.cpu import Cpu, CpuFault
from ..loop.pace import AdjustablePace, stopping_on_interrupt
from ..loop.scans_ahead import LOGIC_CALLERS
from . import actions
from .actions import ALL, Action, action_of, parsed
from .operator_actions import OperatorActions
from .speeds import MAX

WAIT_S = 0.02
"""Longest wait for an action during a pause, before the tap checks for requests, in seconds."""


Reply = Callable[[Mapping[str, object]], None]
"""Function that sends an answer to the page of the request: an object with the key `ok` or `refused`."""

PAGE_ACTIONS = {**actions.ACTIONS, **actions.TYPED}
"""Actions that a monitor can pass on from a page, by name."""


class Inbox(Protocol):
    """A queue of actions."""

    def pending(self) -> bool:
        """Whether an action is waiting; called after every scan."""

    def take(self) -> bytes:
        """Return the next action as JSON with the keys id and order."""

    def wait(self, seconds: float) -> None:
        """Wait for an action, at most `seconds`."""


class Stops(Protocol):
    """A program that supports breakpoints, such as a debugger."""

    @property
    def stops(self) -> tuple[Any, ...]:
        """The breakpoints that the latest scan reached."""

    @property
    def ran(self) -> tuple[int, ...]:
        """Lines of a Python program that ran in the latest scan; empty if no breakpoint is on a line."""

    def break_at(self, routine: str, rung: int, when: Any = "true") -> None:
        """Set a breakpoint at a rung, as in `Debugger.break_at`; raise ValueError for an unknown rung."""

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a tag; raise ValueError for an unknown tag."""

    def remove_breakpoint(self, at: str, rung: int | None = None, when: Any = "true") -> None:
        """Remove one breakpoint: at a rung of a routine, or on a tag."""

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""


@dataclass(slots=True)
class SessionState:
    """A session's state, as shown to monitors."""

    paused: bool = False
    speed: float | None = 1.0  # times real time; None = as fast as possible
    breakpoints: list[str] = field(default_factory=list)
    met: list[str] = field(default_factory=list)  # the breakpoints that caused the latest pause
    ran: tuple[int, ...] = ()  # see `Stops`
    fault: str = ""  # the fault that stopped the CPU; "" while it runs


class Session:
    """The loop that runs a CPU's scans and carries out actions between them.

    Args:
        send: function that sends a message to the monitor: an answer, or the state.
        stops: the program, if it supports breakpoints.
        live: whether the rack has real ports, which rule out pause, step and speed.
        reload: function that reloads the program, and adds a takeover when the program is ready. Its argument
            names the sequences that restart. None if the program can't be reloaded.
        prepare: function that prepares a branch from a scan, or raises ValueError if it can't. Its second
            argument tells whether the branch pauses at that scan. None if branches are not supported.

    Attributes:
        inbox: the queue of actions.
        stops: the program, if it supports breakpoints.
        live: same as the argument.
        repeats: whether it is repeating the scans of the session that it branched from.
        over: whether `end` has been called.
        branch: the scan from which another session begins when this one has ended, or None.
        attend: function that serves the monitor during a pause.
        send_values: function that sends the program's values to the monitor.
        on_fault: function called after a CPU fault in a session that stays open for inspection.
        takeovers: functions that are called once, between two scans. Each returns the action that continues
            with an edited program, or None after it has reported a mistake or a preview.
        edit: function that carries out an action on the program's text; its second argument sends the answer.
            None if the program can't be edited.
    """

    def __init__(
        self,
        cpu: Cpu,
        operator_actions: OperatorActions,
        pacer: AdjustablePace,
        inbox: Inbox,
        send: Callable[[Mapping[str, object]], None],
        *,
        stops: Stops | None = None,
        live: bool = False,
        reload: Callable[[str], None] | None = None,
        prepare: Callable[[int, bool], None] | None = None,
    ) -> None:
        self._cpu, self._operator_actions, self._pacer = cpu, operator_actions, pacer
        self.inbox, self._send, self.stops = inbox, send, stops
        self.live, self._reload, self._prepare = live, reload, prepare
        self.repeats = False
        self.state = SessionState(speed=pacer.speed)
        self.over = False
        self.attend: Callable[[], None] = lambda: None
        self.send_values: Callable[[], None] = lambda: None
        self.on_fault: Callable[[CpuFault], object] = lambda _fault: None
        self.takeovers: deque[Callable[[], Action | None]] = deque()
        self.edit: Callable[[actions.ToEditor, Reply], None] | None = None
        self.branch: int | None = None
        self._step_end: int | None = None  # the scan before which a step ends
        self._step_answer: dict[str, object] | None = None  # sent when the step ends
        self._fault: CpuFault | None = None
        self._next_scan = 0  # the scan before which the present action takes effect

    @property
    def scan(self) -> int:
        """Number of the next scan."""
        return self._cpu.scan

    # --- running

    def repeat_to(self, scan: int) -> None:
        """Run up to a scan as fast as possible, without actions or breakpoints.

        If the program now behaves differently and faults the CPU, the fault is shown.
        """
        if scan > self._cpu.scan:
            self.repeats = True
            with stopping_on_interrupt(self.end, *LOGIC_CALLERS):
                self._run(scan, keep_open=True)
            self.repeats = False

    def set_speed(self, speed: float | None) -> None:
        """Set the speed as a multiple of real time; None = as fast as possible."""
        self.state.speed = self._pacer.speed = speed

    def run(self, scans: int | None = None, *, paused: bool = False) -> None:
        """Run until `end` is called, or for a number of scans.

        Args:
            scans: number of scans, including those run as steps; None = no limit.
            paused: whether to begin with a pause.

        Raises:
            CpuFault: see `Cpu.run`. If there is no limit, the session first waits for `end`, so that the
                operator can inspect the fault.
            KeyboardInterrupt: Ctrl-C was pressed a second time.
        """
        end = None if scans is None else self._cpu.scan + scans
        self.state.paused = paused or self._fault is not None
        with stopping_on_interrupt(self.end, *LOGIC_CALLERS):
            self._show()
            while not self.over and (end is None or self._cpu.scan < end):
                if self.state.paused:
                    self._wait_for_actions()
                else:
                    self._run(end, keep_open=end is None)
            if self._fault is not None and self.branch is None:
                raise self._fault

    def end(self) -> None:
        """End the session between two scans; can be called from a signal handler."""
        self.over = True
        self._cpu.stop()

    def _run(self, end: int | None, *, keep_open: bool) -> None:
        """Run scans until they are done, or the CPU is stopped.

        Args:
            keep_open: whether to show a CPU fault and pause; otherwise the fault is raised.
        """
        try:
            self._run_scans(end)
        except CpuFault as fault:
            if not keep_open:
                raise
            self._fault = fault
            self.state.fault = str(fault)
            self.state.paused = True
            self._end_step(refusal=_fault_refusal(fault))
            self._show()
            self.on_fault(fault)

    def _run_scans(self, end: int | None) -> None:
        end_scans = [scan for scan in (self._step_end, end) if scan is not None]
        self._cpu.run(min(end_scans) - self._cpu.scan if end_scans else None)
        if self._step_end is not None and self._cpu.scan >= self._step_end and not self.state.paused:
            self._pause()

    def _wait_for_actions(self) -> None:
        """Wait up to `WAIT_S` for actions, and carry them out."""
        self.attend()
        self.inbox.wait(WAIT_S)
        self.obey_all(self._cpu.now_ns, self._cpu.scan)

    def attend_scan(self, at_ns: int, scan: int) -> None:
        """Check breakpoints and carry out actions; called after a scan only if there are any."""
        if self.state.breakpoints:
            self._check_breakpoints()
        self.obey_all(at_ns, scan)

    def _check_breakpoints(self) -> None:
        """Collect the breakpoints that the latest scan reached, and pause unless scans are being repeated."""
        if self.stops is None:
            return
        stops, self.state.ran = self.stops.stops, self.stops.ran
        if stops and not self.repeats:
            self.state.met = [str(stop) for stop in stops]
            self._pause()

    # --- actions

    def obey_all(self, at_ns: int, scan: int) -> None:
        """Carry out the waiting actions, and answer each one.

        A step is answered after its last scan. At least one scan runs before the next action, so that "press,
        step, release" makes a pulse no matter how fast the actions arrive.
        """
        while self.takeovers and not self.repeats:
            self._take_over(self.takeovers.popleft(), at_ns, scan)
        while not self.repeats and not self.over and self.inbox.pending():
            number: object = None
            try:
                message = parsed(self.inbox.take())
                number = message["id"]
                action = action_of(message["order"], PAGE_ACTIONS)
                if isinstance(action, actions.ToEditor):
                    self.ask_editor(action, self._answer_to(number))
                    continue
                self.obey(action, at_ns, scan)
            except ValueError as error:
                self._send({"answer": {"id": number, "refused": str(error)}})
            except Exception as error:  # an action never faults the CPU, even if a handler is wrong
                text = f"it can't be carried out: {type(error).__name__}: {error}"
                self._send({"answer": {"id": number, "refused": text}})
            else:
                answer = {"id": number, "ok": True, "scan": scan}
                if isinstance(action, actions.Step):
                    self._step_answer = answer
                    return
                self._send({"answer": answer})

    def _answer_to(self, number: object) -> Reply:
        return lambda result: self._send({"answer": {"id": number, **result}})

    def ask_editor(self, action: actions.ToEditor, reply: Reply) -> None:
        """Pass on an action on the program's text; raise ValueError if the program can't be edited now."""
        if self.edit is None:
            raise ValueError("this program can't be edited while it runs")
        if isinstance(action, actions.Online) and action.step not in _ALLOWED_AFTER_FAULT:
            self._refuse_after_fault()
        self.edit(action, reply)

    def _take_over(self, takeover: Callable[[], Action | None], at_ns: int, scan: int) -> None:
        """Continue with an edited program, or report the program's mistake to the page."""
        try:
            action = takeover()
            if action is None:
                return
            self._refuse_after_fault()
            self._operator_actions.act(action, at_ns, scan)
        except Exception as error:  # the running program continues after any error of the edited one
            self._send({"mistake": {"text": str(error), "file": "", "line": None}})
            return
        self.state.breakpoints, self.state.met = [], []
        if self.stops is not None:
            self.stops.clear_breakpoints()
        self._show()
        self.send_values()

    def obey(self, action: Action, at_ns: int, scan: int) -> None:
        """Carry out an action; if that is impossible, raise ValueError and change nothing.

        Args:
            at_ns: virtual time of the next scan, before which the action takes effect.
        """
        if not isinstance(action, actions.Branch):
            self._refuse_after_fault()
        self._next_scan = scan
        handler = _HANDLERS.get(type(action))
        if handler is not None:
            handler(self, action)
        self._operator_actions.act(action, at_ns, scan)
        self._show()

    def _refuse_after_fault(self) -> None:
        """Raise a ValueError if the CPU has faulted."""
        if self._fault is not None:
            raise ValueError(_fault_refusal(self._fault))

    def _show(self) -> None:
        self._send({"state": self.described()})

    def described(self) -> dict[str, object]:
        """Return the state as a message."""
        speed = MAX if self.state.speed is None else self.state.speed
        return {**asdict(self.state), "speed": speed, "scan": self._cpu.scan}

    # --- handlers: one action each

    def _pause(self, _action: object = None) -> None:
        """Stop after the current scan; this ends a step."""
        self._refuse_if_live("pause")
        self.state.paused = True
        self._end_step()
        self._cpu.stop()
        self._show()

    def _continue(self, _action: object) -> None:
        """End the pause and the current step."""
        self.state.paused = False
        self.state.met = []
        self._end_step()

    def _step(self, action: actions.Step) -> None:
        """Run a number of scans, then pause."""
        self._refuse_if_live("step")
        self._continue(action)
        self._step_end = self._next_scan + action.scans
        self._cpu.stop()

    def _end_step(self, refusal: str = "") -> None:
        """End the current step, complete or not, and answer it; do nothing if there is no step."""
        self._step_end = None
        if self._step_answer is not None:
            answer, self._step_answer = self._step_answer, None
            self._send({"answer": {"id": answer["id"], "refused": refusal} if refusal else answer})

    def _speed(self, action: actions.Speed) -> None:
        self._refuse_if_live("speed")
        self.set_speed(None if isinstance(action.factor, str) else float(action.factor))

    def _break(self, action: actions.Breakpoint) -> None:
        """Set a breakpoint on a rung or a tag, unless it is set already."""
        self._refuse_if_live("breakpoint")
        if action.at not in self.state.breakpoints:
            routine_or_tag, rung, condition = _parse_breakpoint(action.at)
            if rung is None:
                self._debugger().break_on(routine_or_tag)
            else:
                self._debugger().break_at(routine_or_tag, rung, condition)
            self.state.breakpoints.append(action.at)

    def _unbreak(self, action: actions.RemoveBreakpoint) -> None:
        """Remove a breakpoint, or all; the program keeps a breakpoint that another text also names."""
        if action.at == ALL:
            self._debugger().clear_breakpoints()
            self.state.breakpoints = []
            return
        breakpoints = self.state.breakpoints
        if action.at not in breakpoints:
            raise ValueError(f"no breakpoint at {action.at}; there are {', '.join(breakpoints) or 'none'}")
        remaining = [location for location in breakpoints if location != action.at]
        if not any(_is_same_breakpoint(action.at, location) for location in remaining):
            self._debugger().remove_breakpoint(*_parse_breakpoint(action.at))
        self.state.breakpoints = remaining

    def _debugger(self) -> Stops:
        """Return the program's breakpoints; raise a ValueError if it has none."""
        if self.stops is None:
            raise ValueError("the program has no breakpoints")
        return self.stops

    def _begin_branch(self, action: actions.Branch) -> None:
        """Prepare another session that begins at an earlier scan, and end this one."""
        self._refuse_if_live("branch")
        if action.scan > self._next_scan:
            raise ValueError(f"scan {action.scan} has not been run yet; the next one is {self._next_scan}")
        if self._prepare is None:
            raise ValueError("this session has no branches")
        self._prepare(action.scan, action.paused)
        self.branch = action.scan
        self.end()

    def _load_again(self, action: actions.Reload) -> None:
        if self._reload is None:
            raise ValueError("this program can't be edited while it runs")
        self._reload(action.restart)

    def _refuse_if_live(self, action_name: str) -> None:
        if self.live:
            raise ValueError(
                f"{action_name}: a real controller does not wait, so scans keep step with the clock"
            )


def _fault_refusal(fault: CpuFault) -> str:
    """Return the message that refuses every action except a branch."""
    return f"the CPU has faulted in {fault}: branch from an earlier scan"


_ALLOWED_AFTER_FAULT = ("accept", "cancel", "save")
"""Steps of an online edit that are allowed after a fault, since they do not need a running program."""

_RUNG = re.compile(r"(?P<routine>.+)\.(?P<rung>\d+)(?: (?P<when>changes|executes))?")
"""A rung, `Main.3` or `Main.3 changes`. A bit of a tag looks the same, so a breakpoint names its tag."""


def _is_same_breakpoint(text: str, other: str) -> bool:
    """Return whether two texts name the same breakpoint, as `Main.3` and `main.3` do."""
    return text == other or (text.upper() == other.upper() and _RUNG.fullmatch(text) is not None)


def _parse_breakpoint(text: str) -> tuple[str, int | None, str]:
    """Return a rung breakpoint's routine, rung and condition; for a tag breakpoint, the tag and None."""
    rung = _RUNG.fullmatch(text)
    if rung is None:
        return text, None, "true"
    return rung["routine"], int(rung["rung"]), rung["when"] or "true"


_HANDLERS: Mapping[type[Action], Callable[[Session, Any], None]] = {
    actions.Pause: Session._pause,
    actions.Continue: Session._continue,
    actions.Step: Session._step,
    actions.Speed: Session._speed,
    actions.Breakpoint: Session._break,
    actions.RemoveBreakpoint: Session._unbreak,
    actions.Reload: Session._load_again,
    actions.Branch: Session._begin_branch,
}
"""Handlers for the actions that change the session itself."""
