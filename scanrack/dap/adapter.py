"""The adapter: it answers requests and keeps the client's current position.

    client  --request-->  requests.py, a table  -->  a function of the adapter  --response-->
            <--event----  stopped, continued, output, breakpoint

Requests are carried out between two scans, in the thread that runs the scans.
"""

from __future__ import annotations

import traceback
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from queue import Empty
from types import MappingProxyType
from typing import Any, Protocol, TypeVar

from scanrack.jobs.load.program import lines_marked
from typing_extensions import override

from .breakpoints import Breakpoint, Hit
from .cursor import Cursor, Spot
from .protocol import DebugError, Json
from .subject import SearchCanceledError, Subject
from .view import Tree, View
from .wire import MalformedMessageError, Wire

THREAD = 1
"""Id of the only thread; it represents the scan."""

VIEWS = 16
"""Maximum number of executed scans that are cached."""

NOTHING: Mapping[str, Any] = MappingProxyType({})

T = TypeVar("T")

Start = Callable[["Adapter"], None]
"""A function that debugs a subject until the client ends the session."""


class Adapter:
    """A session with a client.

    Attributes:
        subject, driver: the scans, and the driver that runs them; None before launch or attach.
        cursor: the client's current position; None while scans are running, or before the first scan.
        tree: the values that the client opened at the current position; None before the first value.
        running: whether scans are running, or a recording is being searched.
        configured: whether the client has set its breakpoints.
        stop_on_entry: whether to stop before the first scan.
        breakpoints: the breakpoints that are set, by kind; for lines, the kind includes the file.
        breakpoint_count: number of breakpoints so far, from which the next id is derived.
        start: function that runs after launch or attach; None before.
        reason: the reason for the last stop, and its text.
        returns_to_present: whether the next continue from a past scan returns to the present.
        searching: whether the past is being searched for a breakpoint.
        cancels_search: whether the client has paused the search.
        over: whether the client has ended the session.
        waits: whether a pytest test is waiting for launch or attach.
    """

    def __init__(self, wire: Wire, requests: Mapping[str, Any]) -> None:
        self.wire, self._requests = wire, requests
        # the session
        self.start: Start | None = None
        self.configured = self.over = self.waits = False
        self.stop_on_entry = True
        self.subject: Subject | None = None
        self.driver: Driver | None = None
        # the position
        self.running = False
        self.cursor: Cursor | None = None
        self.tree: Tree | None = None
        self.reason: Json = {}
        self.returns_to_present = False
        self._views: deque[View] = deque(maxlen=VIEWS)
        self._pending_moves: list[Callable[[], object]] = []
        # the breakpoints
        self.breakpoints: dict[str, list[Breakpoint]] = {}
        self.breakpoint_count = 0
        self.searching = self.cancels_search = False

    def run(self) -> None:
        """Serve the client until it ends the session."""
        with lines_marked():
            self._run()

    def _run(self) -> None:
        """Answer requests; after each launch or attach, debug its subject until it ends."""
        while not self.over:
            if self.start is not None:
                start, self.start = self.start, None
                with redirect_stdout(Console(self, "stdout")), redirect_stderr(Console(self, "stderr")):
                    try:
                        start(self)
                    except (ValueError, OSError) as error:
                        self.output(f"{error}\n", "stderr")
                    except Exception:  # a defect of this code: report it to the waiting client
                        self.output(traceback.format_exc(), "stderr")
                self.subject = self.driver = self.cursor = None
                self.event("terminated")
                continue
            self.serve(None)

    # --- messages

    def serve(self, seconds: float | None) -> bool:
        """Answer the requests that have arrived; return whether there were any.

        Args:
            seconds: longest wait for the first request, s; None means no limit.
        """
        served, was_waiting = False, self.waits
        while not self.over:
            try:
                message = self.wire.next(seconds)
            except Empty:
                break
            if message is None:
                self.over = True
                if self.driver is not None:
                    self.driver.end()
                break
            self.handle_message(message)
            served, seconds = True, 0
            if self.start is not None or (was_waiting and not self.waits):
                break
        return served

    def handle_message(self, message: Json | MalformedMessageError) -> None:
        """Answer one message; the session continues even if the message is invalid."""
        if isinstance(message, MalformedMessageError):
            self.output(f"{message}\n", "stderr")
            return
        number, command = message.get("seq"), message.get("command")
        if message.get("type") != "request" or not isinstance(command, str) or type(number) is not int:
            self.output("a message must be a request with seq and command\n", "stderr")
            return
        try:
            body = self._carry_out(command, message.get("arguments"))
        except (ValueError, OSError) as error:
            self._respond(number, command, error=str(error))
        except Exception as error:  # a defect of this code must not end the session
            traceback.print_exc()
            self._respond(number, command, error=f"{command}: {type(error).__name__}: {error}")
        else:
            self._respond(number, command, body=body)
        moves, self._pending_moves = self._pending_moves, []
        for move in moves:
            self._move(move)

    def _move(self, move: Callable[[], object]) -> None:
        """Carry out a move; after a failure, report the reason at the old position."""
        old_cursor = self.cursor
        try:
            move()
        except Exception as error:  # also a defect of this code: the client waits for a stop
            is_expected = isinstance(error, ValueError | OSError)
            self.output(f"{error}\n" if is_expected else traceback.format_exc(), "stderr")
            if old_cursor is not None:
                self.leave()
                self.cursor = old_cursor
                old_cursor.go(old_cursor.spot)
                self.stopped("step", str(error))
            elif self.driver is not None:
                self.driver.end()

    def _carry_out(self, command: str, arguments: object) -> Json | None:
        """Carry out a request, or raise DebugError; return the body of the response, or None."""
        request = self._requests.get(command)
        if request is None:
            raise DebugError(f"no request {command[:60]!r}")
        if not isinstance(arguments, dict | None):
            raise DebugError(f"{command}: arguments must be an object")
        if request.needs == "nothing":
            pass
        elif self.subject is None:
            raise DebugError(f"{command}: nothing is debugged yet: launch or attach first")
        elif request.needs == "stop" and (self.running or self.cursor is None):
            raise DebugError(f"{command}: scans run; pause first")
        body: Json | None = request.handle(self, arguments or {})
        return body

    def _respond(self, number: int, command: str, *, body: Json | None = None, error: str = "") -> None:
        message: Json = {"type": "response", "request_seq": number, "success": not error, "command": command}
        if error:
            message |= {"message": error, "body": {"error": {"id": 1, "format": error, "showUser": True}}}
        elif body is not None:
            message["body"] = body
        self.wire.send(message)

    def event(self, name: str, **body: Any) -> None:
        """Send an event."""
        self.wire.send({"type": "event", "event": name, "body": body})

    def output(self, text: str, category: str = "console", *, more: Mapping[str, Any] = NOTHING) -> None:
        """Print in the client's console; `more` is the file and line as protocol fields."""
        self.event("output", category=category, output=text, **more)

    def after_response(self, move: Callable[[], object]) -> None:
        """Call `move` once the response to the current request has been sent."""
        self._pending_moves.append(move)

    # --- the client's position

    def begin(self, subject: Subject, driver: Driver) -> None:
        """Begin debugging a subject; the client then sets its breakpoints."""
        is_restart = self.subject is not None
        self.subject, self.driver = subject, driver
        self.cursor, self.running = None, False
        self._views.clear()
        if not is_restart:
            self.configured = False
            self.event("initialized")

    def all_breakpoints(self) -> list[Breakpoint]:
        """Return the breakpoints that have a line in the running program or do not need one."""
        return [point for points in self.breakpoints.values() for point in points if point.placed]

    def stop_points(self) -> list[Breakpoint]:
        """Return the breakpoints at which execution stops; log points do not stop it."""
        return [point for point in self.all_breakpoints() if not point.log]

    def the_subject(self) -> Subject:
        """Return the debugged subject; it must exist."""
        assert self.subject is not None
        return self.subject

    def the_driver(self) -> Driver:
        """Return the driver of the scans; it must exist."""
        assert self.driver is not None
        return self.driver

    def place(self) -> Cursor:
        """Return the client's position; raise DebugError while scans are running."""
        if self.cursor is None:
            raise DebugError("scans run; pause first")
        return self.cursor

    def the_tree(self) -> Tree:
        """Return the tree of opened values at the client's position."""
        if self.tree is None:
            cursor = self.place()
            self.tree = Tree(cursor.view, tuple(self.the_subject().forced(cursor.scan)))
        return self.tree

    def in_past(self) -> bool:
        """Whether the client is looking at a scan before the latest one of a running rack."""
        subject = self.the_subject()
        return subject.live and self.cursor is not None and self.cursor.scan < subject.extent[1]

    def look_elsewhere(self, search: Callable[[], T]) -> T:
        """Return the result of a search in the past; the client's position is then restored."""
        cursor = self.place()
        scan, spot = cursor.scan, cursor.spot
        self.leave()
        try:
            return search()
        finally:
            self.look_at(scan).go(spot)

    def last_change(self, tag: str) -> int | None:
        """Return the last scan, up to the current one, that changed a tag; None if there is none."""
        scan = self.place().scan
        return self.look_elsewhere(lambda: self.the_subject().last_change(tag, scan))

    def leave(self) -> None:
        """Return the memory to the replayer of scans."""
        if self.cursor is not None:
            self.cursor.view.leave()
        self.cursor, self.tree = None, None

    def look_at(self, scan: int, spot: str = "start") -> Cursor:
        """Move to the `start`, the `last` rung, or the `end` of a scan."""
        self.leave()
        view = next((cached_view for cached_view in self._views if cached_view.scan == scan), None)
        if view is None:
            view = self.the_subject().view(scan)
            self._views.append(view)
        self.cursor = Cursor(view)
        self.cursor.go(getattr(self.cursor, spot))
        return self.cursor

    def forget_views(self) -> None:
        """Clear the cache of scans, because the next scans belong to a different program."""
        self._views.clear()

    def go_to(self, spot: Spot) -> None:
        """Move to another place in the scan."""
        self.place().go(spot)
        self.tree = None

    def stopped(self, reason: str, text: str = "", hits: tuple[Breakpoint, ...] = ()) -> None:
        """Notify the client that execution has stopped at the current position."""
        self.running, self.tree = False, None
        self.returns_to_present = False
        self.reason = {"reason": reason, "text": text}
        details: Json = {"hitBreakpointIds": [hit.number for hit in hits]} if hits else {}
        if text:
            details |= {"description": text, "text": text}
        self.event("stopped", reason=reason, threadId=THREAD, allThreadsStopped=True, **details)

    # --- breakpoints that scans have met

    def poll(self, scan: int) -> None:
        """Answer requests while searching the past; raise SearchCanceledError if the client pauses."""
        if self.wire.waiting:
            self.serve(0)
        if self.cancels_search or self.over:
            self.cancels_search = False
            raise SearchCanceledError(scan)

    def hits_in(self, scan: int) -> list[Hit]:
        """Return the breakpoints at which execution stops in a scan."""
        stop_points = self.stop_points()
        if not stop_points:
            return []
        self.leave()
        return self.the_subject().hits(stop_points, scan)

    def stop_at_hit(self, scan: int, hits: list[Hit], *, backwards: bool = False) -> None:
        """Move to the first breakpoint in a scan, or backwards to the last one, and stop."""
        cursor = self.look_at(scan)
        spots = [cursor.spot_of(point) for point, _text in hits]
        self._stop_at((max if backwards else min)(spots, key=Spot.position), hits)

    def _stop_at(self, spot: Spot, hits: list[Hit]) -> None:
        """Stop at the place of one or more hits, and report the hits there."""
        cursor = self.place()
        hits_here = [hit for hit in hits if cursor.spot_of(hit.breakpoint) == spot]
        self.go_to(spot)
        reason = REASONS[hits_here[0].breakpoint.kind]
        self.stopped(reason, hits_here[0].text, tuple(hit.breakpoint for hit in hits_here))

    def stop_in_scan(self, *, backwards: bool) -> bool:
        """Stop at the next breakpoint in the same scan, or the previous one; return whether one exists."""
        cursor = self.place()
        scan, spot = cursor.scan, cursor.spot
        if scan < self.the_subject().extent[0]:
            return False  # of the program before an edit
        hits = self.hits_in(scan)
        cursor = self.look_at(scan)
        cursor.go(spot)
        spots = [cursor.spot_of(point) for point, _text in hits]
        if backwards:
            spots = [other for other in spots if other.position() < spot.position()]
        else:
            spots = [other for other in spots if other.position() > spot.position()]
        if not spots:
            return False
        self._stop_at((max if backwards else min)(spots, key=Spot.position), hits)
        return True


class Console(StringIO):
    """A stream that prints to the client's console."""

    def __init__(self, adapter: Adapter, category: str) -> None:
        super().__init__()
        self._adapter, self._category = adapter, category

    @override
    def write(self, text: str) -> int:
        if not isinstance(text, str):
            raise TypeError("this is a stream of text")
        if text:
            self._adapter.output(text, self._category)
        return len(text)


REASONS = {
    "line": "breakpoint",
    "function": "function breakpoint",
    "data": "data breakpoint",
    "exception": "exception",
}
"""The protocol's reason for a stop, by kind of breakpoint."""


class Driver(Protocol):
    """Runs the scans of a subject; each kind of subject has its own driver."""

    def begin(self, *, stop: bool) -> None:
        """Begin after all breakpoints are set; with `stop`, stop before the first scan."""

    def go(self) -> None:
        """Run scans after the latest one, until a breakpoint or a pause."""

    def pause(self) -> None:
        """Request a stop (see `Adapter.stopped`); raise DebugError if it is refused."""

    def step(self) -> None:
        """Run one scan, and stop at its start; raise DebugError if no further scan exists."""

    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        """Replace the active breakpoints; raise ExpressionError if a condition can't be evaluated."""

    def apply(self, action: Any) -> None:
        """Apply an operator action to the rack; raise DebugError if the rack refuses actions."""
        raise DebugError("this is a recording: its values can't be changed; branch from one of its scans")

    def edit(self, step: str) -> None:
        """Test the saved program (`try`), accept it (`take`), or `cancel` the test; print the result."""
        raise DebugError("only a running rack continues with an edited program")

    def branch(self, scan: int) -> None:
        """Begin a session that repeats this one up to a scan and continues from there."""
        raise DebugError("no branch can begin here")

    def end(self) -> None:
        """End the session."""
