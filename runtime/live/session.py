"""A session: scans with pause, steps and speed, and orders between them.

    run:     scan scan scan | pause ...................... | go: scan scan
    orders        ^    ^            ^ one act each, before the next scan

The session runs in the thread of the scan loop. While scans run, the tap checks for orders after every scan;
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
"""Longest single wait for commands during a pause, and for requests to the tap, in seconds."""


Reply = Callable[[Mapping[str, object]], None]
"""Sends an answer to the page that requested it: `ok` and more, or `refused`."""

GIVEN = {**actions.ACTIONS, **actions.TYPED}
"""Orders that a monitor may pass on, by name."""


class Inbox(Protocol):
    """The source of orders."""

    def pending(self) -> bool:
        """Whether an order waits; called after every scan."""

    def take(self) -> bytes:
        """Return the next order, JSON with the keys id and order."""

    def wait(self, seconds: float) -> None:
        """Wait for an order, at most this long."""


class Stops(Protocol):
    """A program with breakpoints: a debugger."""

    @property
    def stops(self) -> tuple[Any, ...]:
        """The breakpoints met in the latest scan."""

    @property
    def ran(self) -> tuple[int, ...]:
        """Lines of a program in Python that ran in the latest scan, while there is a breakpoint on one."""

    def break_at(self, routine: str, rung: int, when: Any = "true") -> None:
        """Set a breakpoint at a rung, see `Debugger.break_at`; ValueError for an unknown one."""

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a tag; ValueError for an unknown one."""

    def remove_breakpoint(self, at: str, rung: int | None = None, when: Any = "true") -> None:
        """Remove a breakpoint at a rung of a routine, or on a tag; the others stay as they are."""

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""


@dataclass(slots=True)
class SessionState:
    """The state of a session for monitors."""

    paused: bool = False
    speed: float | None = 1.0  # times real time; None = as fast as possible
    breakpoints: list[str] = field(default_factory=list)
    met: list[str] = field(default_factory=list)  # the breakpoints that ended the latest run
    ran: tuple[int, ...] = ()  # see `Stops`
    fault: str = ""  # the fault that stopped the CPU; "" while it runs


class Session:
    """The loop around a CPU.

    Args:
        tell: sends messages to the monitor: an answer, or the state.
        stops: the program, if it supports breakpoints.
        live: whether there are real ports, which exclude pause, step and speed.
        reload: loads the program again, and passes it on when ready; None if that is impossible. Its
            argument names the sequences that restart.
        prepare: prepares a branch from a scan, ValueError if it can't; None without branches.

    Attributes:
        inbox: the source of orders.
        stops: the program, if it supports breakpoints.
        live: see the argument.
        repeats: whether it repeats the scans of a session from which it branches.
        over: whether the session has been ended.
        branch: the scan from which another session should begin, or None.
        attend: serves the monitor during a pause.
        give: sends the values of the program to the monitor.
        on_fault: called after a fault of the CPU in a session that stays open for inspection.
        takeovers: each is called once, between two scans: it returns the order that continues with an edited
            program, or None for a mistake or a preview, which it reports.
        edit: requests the text of the program, or previews an edited one; called with a function that sends
            the answer. None if the program can't be edited.
    """

    def __init__(
        self,
        cpu: Cpu,
        hands: OperatorActions,
        pacer: AdjustablePace,
        inbox: Inbox,
        tell: Callable[[Mapping[str, object]], None],
        *,
        stops: Stops | None = None,
        live: bool = False,
        reload: Callable[[str], None] | None = None,
        prepare: Callable[[int, bool], None] | None = None,
    ) -> None:
        self._cpu, self._hands, self._pacer = cpu, hands, pacer
        self.inbox, self._tell, self.stops = inbox, tell, stops
        self.live, self._reload, self._prepare = live, reload, prepare
        self.repeats = False
        self.state = SessionState(speed=pacer.speed)
        self.over = False
        self.attend: Callable[[], None] = lambda: None
        self.give: Callable[[], None] = lambda: None
        self.on_fault: Callable[[CpuFault], object] = lambda _fault: None
        self.takeovers: deque[Callable[[], Action | None]] = deque()
        self.edit: Callable[[actions.ToEditor, Reply], None] | None = None
        self.branch: int | None = None
        self._until: int | None = None
        self._stepping: dict[str, object] | None = None
        self._fault: CpuFault | None = None
        self._next = 0

    @property
    def scan(self) -> int:
        """Number of the next scan."""
        return self._cpu.scan

    # --- running

    def repeat_to(self, scan: int) -> None:
        """Run up to a scan as fast as possible; orders and breakpoints wait until then.

        If the program now behaves differently and faults the CPU, the fault is shown.
        """
        if scan > self._cpu.scan:
            self.repeats = True
            with stopping_on_interrupt(self.end, *LOGIC_CALLERS):
                self._run_or_fault(scan, shown=True)
            self.repeats = False

    def set_speed(self, speed: float | None) -> None:
        """Set the speed: times real time, or None for as fast as possible."""
        self.state.speed = self._pacer.speed = speed

    def run(self, scans: int | None = None, *, paused: bool = False) -> None:
        """Run until `end` is called, or a number of scans is done.

        Args:
            scans: total number of scans; None = no end.
            paused: begin with a pause.

        Raises:
            CpuFault: see `Cpu.run`. A session without an end waits for `end` first, so that the fault can be
            inspected.
            KeyboardInterrupt: a second Ctrl-C.
        """
        end = None if scans is None else self._cpu.scan + scans
        self.state.paused = paused or self._fault is not None
        with stopping_on_interrupt(self.end, *LOGIC_CALLERS):
            self._show()
            while not self.over and (end is None or self._cpu.scan < end):
                if self.state.paused:
                    self._rest()
                else:
                    self._run_or_fault(end, shown=end is None)
            if self._fault is not None and self.branch is None:
                raise self._fault

    def end(self) -> None:
        """End the session between two scans; may be called from a signal handler."""
        self.over = True
        self._cpu.stop()

    def _run_or_fault(self, end: int | None, *, shown: bool) -> None:
        """Run scans; show a fault of the CPU until the session ends, or raise it."""
        try:
            self._run(end)
        except CpuFault as fault:
            if not shown:
                raise
            self._fault = fault
            self.state.fault = str(fault)
            self.state.paused = True
            self._end_step(refused=_faulted(fault))
            self._show()
            self.on_fault(fault)

    def _run(self, end: int | None) -> None:
        """Run scans until they are done, or the CPU is stopped."""
        end_scans = [instant for instant in (self._until, end) if instant is not None]
        self._cpu.run(min(end_scans) - self._cpu.scan if end_scans else None)
        if self._until is not None and self._cpu.scan >= self._until and not self.state.paused:
            self._pause()

    def _rest(self) -> None:
        """Wait for orders, and carry them out."""
        self.attend()
        self.inbox.wait(WAIT_S)
        self.obey_all(self._cpu.now_ns, self._cpu.scan)

    def attend_scan(self, at_ns: int, scan: int) -> None:
        """Check the breakpoints, and carry out orders; called after a scan if there are any."""
        if self.state.breakpoints:
            self._look()
        self.obey_all(at_ns, scan)

    def _look(self) -> None:
        if self.stops is None:
            return
        stops, self.state.ran = self.stops.stops, self.stops.ran
        if stops and not self.repeats:
            self.state.met = [str(stop) for stop in stops]
            self._pause()

    # --- orders

    def obey_all(self, at_ns: int, scan: int) -> None:
        """Carry out the waiting orders, and answer each.

        A step is answered after its last scan. At least one of its scans runs before the next order acts, so
        that "press, step, release" is a pulse, however fast the orders arrive.
        """
        while self.takeovers and not self.repeats:
            self._take_over(self.takeovers.popleft(), at_ns, scan)
        while not self.repeats and not self.over and self.inbox.pending():
            number: object = None
            try:
                message = parsed(self.inbox.take())
                number = message["id"]
                order = action_of(message["order"], GIVEN)
                if isinstance(order, actions.ToEditor):
                    self.ask_editor(order, self._answer_to(number))
                    continue
                self.obey(order, at_ns, scan)
            except ValueError as error:
                self._tell({"answer": {"id": number, "refused": str(error)}})
            except Exception as error:  # an order never faults the CPU, even if this code is wrong
                text = f"it can't be carried out: {type(error).__name__}: {error}"
                self._tell({"answer": {"id": number, "refused": text}})
            else:
                answer = {"id": number, "ok": True, "scan": scan}
                if isinstance(order, actions.Step):
                    self._stepping = answer
                    return
                self._tell({"answer": answer})

    def _answer_to(self, number: object) -> Reply:
        return lambda result: self._tell({"answer": {"id": number, **result}})

    def ask_editor(self, order: actions.ToEditor, reply: Reply) -> None:
        """Pass on an order about the program's text; ValueError if the program can't be edited now."""
        if self.edit is None:
            raise ValueError("this program can't be edited while it runs")
        if isinstance(order, actions.Online) and order.step not in _WITHOUT_SCANS:
            self._refuse_after_fault()
        self.edit(order, reply)

    def _take_over(self, takeover: Callable[[], Action | None], at_ns: int, scan: int) -> None:
        """Continue with an edited program, or report its mistakes to the page."""
        try:
            order = takeover()
            if order is None:
                return
            self._refuse_after_fault()
            self._hands.act(order, at_ns, scan)
        except Exception as error:  # the running program continues despite any error of the edited one
            self._tell({"mistake": {"text": str(error), "file": "", "line": None}})
            return
        self.state.breakpoints, self.state.met = [], []
        if self.stops is not None:
            self.stops.clear_breakpoints()
        self._show()
        self.give()

    def obey(self, order: Action, at_ns: int, scan: int) -> None:
        """Carry out an order; ValueError if it can't be carried out, and nothing has changed.

        Args:
            at_ns: virtual time of the next scan, before which it acts.
        """
        if not isinstance(order, actions.Branch):
            self._refuse_after_fault()
        self._next = scan
        action = _ACTS.get(type(order))
        if action is not None:
            action(self, order)
        self._hands.act(order, at_ns, scan)
        self._show()

    def _refuse_after_fault(self) -> None:
        if self._fault is not None:
            raise ValueError(_faulted(self._fault))

    def _show(self) -> None:
        self._tell({"state": self.described()})

    def described(self) -> dict[str, object]:
        """Return the state as a message."""
        speed = MAX if self.state.speed is None else self.state.speed
        return {**asdict(self.state), "speed": speed, "scan": self._cpu.scan}

    # --- one order each

    def _pause(self, _order: object = None) -> None:
        self._refuse_if_live("pause")
        self.state.paused = True
        self._end_step()
        self._cpu.stop()
        self._show()

    def _go(self, _order: object) -> None:
        self.state.paused = False
        self.state.met = []
        self._end_step()

    def _step(self, order: actions.Step) -> None:
        self._refuse_if_live("step")
        self._go(order)
        self._until = self._next + order.scans
        self._cpu.stop()

    def _end_step(self, refused: str = "") -> None:
        """End and answer a step that is complete or was ended early."""
        self._until = None
        if self._stepping is not None:
            answer, self._stepping = self._stepping, None
            self._tell({"answer": {"id": answer["id"], "refused": refused} if refused else answer})

    def _speed(self, order: actions.Speed) -> None:
        self._refuse_if_live("speed")
        self.set_speed(None if isinstance(order.factor, str) else float(order.factor))

    def _break(self, order: actions.Breakpoint) -> None:
        self._refuse_if_live("breakpoint")
        if order.at not in self.state.breakpoints:
            rung_place, rung, when = _place_of(order.at)
            if rung is None:
                self._with_breakpoints().break_on(rung_place)
            else:
                self._with_breakpoints().break_at(rung_place, rung, when)
            self.state.breakpoints.append(order.at)

    def _unbreak(self, order: actions.RemoveBreakpoint) -> None:
        breakpoints_left = [
            location for location in self.state.breakpoints if location != order.at and order.at != ALL
        ]
        if len(breakpoints_left) == len(self.state.breakpoints) and order.at != ALL:
            breakpoint_list = ", ".join(breakpoints_left) or "none"
            raise ValueError(f"no breakpoint at {order.at}; there are {breakpoint_list}")
        if order.at == ALL:
            self._with_breakpoints().clear_breakpoints()
        elif not any(_is_same(order.at, location_left) for location_left in breakpoints_left):
            self._with_breakpoints().remove_breakpoint(*_place_of(order.at))
        self.state.breakpoints = breakpoints_left

    def _with_breakpoints(self) -> Stops:
        if self.stops is None:
            raise ValueError("the program has no breakpoints")
        return self.stops

    def _begin_branch(self, order: actions.Branch) -> None:
        self._refuse_if_live("branch")
        if order.scan > self._next:
            raise ValueError(f"scan {order.scan} has not been run yet: the next one is {self._next}")
        if self._prepare is None:
            raise ValueError("this session has no branches")
        self._prepare(order.scan, order.paused)
        self.branch = order.scan
        self.end()

    def _load_again(self, order: actions.Reload) -> None:
        if self._reload is None:
            raise ValueError("this program can't be edited while it runs")
        self._reload(order.restart)

    def _refuse_if_live(self, what: str) -> None:
        if self.live:
            raise ValueError(f"{what}: a real controller does not wait, so scans keep step with the clock")


def _faulted(fault: CpuFault) -> str:
    """Return the refusal of every order but a branch."""
    return f"the CPU has faulted in {fault}: branch from an earlier scan"


_WITHOUT_SCANS = ("accept", "cancel", "save")
"""Steps with edited rungs that may be taken after a fault: they do not need a running program."""

_RUNG = re.compile(r"(?P<routine>.+)\.(?P<rung>\d+)(?: (?P<when>changes|executes))?")
"""A rung, `Main.3` or `Main.3 changes`, which no tag looks like: bits of tags are watched as the tags."""


def _is_same(one: str, other: str) -> bool:
    """Whether two texts mean the same breakpoint, as `Main.3` and `main.3` do."""
    return one == other or (one.upper() == other.upper() and _RUNG.fullmatch(one) is not None)


def _place_of(at: str) -> tuple[str, int | None, str]:
    """Return the routine, rung and condition of a breakpoint, or its tag and None."""
    rung = _RUNG.fullmatch(at)
    if rung is None:
        return at, None, "true"
    return rung["routine"], int(rung["rung"]), rung["when"] or "true"


_ACTS: Mapping[type[Action], Callable[[Session, Any], None]] = {
    actions.Pause: Session._pause,
    actions.Continue: Session._go,
    actions.Step: Session._step,
    actions.Speed: Session._speed,
    actions.Breakpoint: Session._break,
    actions.RemoveBreakpoint: Session._unbreak,
    actions.Reload: Session._load_again,
    actions.Branch: Session._begin_branch,
}
"""The orders that act on the session itself."""
