"""Requests that move forward or backward over instructions, rungs, routines and scans."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .protocol import DebugError, Json
from .subject import SearchCanceledError

if TYPE_CHECKING:
    from .adapter import Adapter

GRANULARITIES = ("statement", "line", "instruction")


def go(adapter: Adapter, _arguments: Json) -> Json:
    """Run to the next breakpoint."""
    if adapter.in_past():
        _refuse_or_return(adapter)
    adapter.running = True
    adapter.after_response(
        lambda: None if adapter.stop_in_scan(backwards=False) else adapter.the_driver().go()
    )
    return {"allThreadsContinued": True}


def _refuse_or_return(adapter: Adapter) -> None:
    """Refuse the first continue from a past scan and list the commands; on the second, go to the latest."""
    scan, last = adapter.place().scan, adapter.the_subject().extent[1]
    if adapter.returns_to_present:
        adapter.returns_to_present = False
        adapter.look_at(last, "end")
        return
    adapter.returns_to_present = True
    raise DebugError(
        f"this is scan {scan:,}, and the rack is at scan {last:,}: continue again to run from there, "
        "evaluate `return` to go there, or `branch` to continue here in a new session"
    )


def pause(adapter: Adapter, _arguments: Json) -> None:
    """Stop after the current scan, or cancel the search of the past."""
    if adapter.searching:
        adapter.cancels_search = True
    elif adapter.running:
        adapter.the_driver().pause()


def next_(adapter: Adapter, arguments: Json) -> None:
    """Step to the next rung or instruction without stepping into routines."""
    by_instruction = _by_instruction(arguments)
    adapter.after_response(lambda: _onward(adapter, adapter.place().depth, by_instruction=by_instruction))


def step_in(adapter: Adapter, arguments: Json) -> None:
    """Go to the next rung or instruction, including those of a called routine."""
    by_instruction = _by_instruction(arguments)
    adapter.after_response(lambda: _onward(adapter, None, by_instruction=by_instruction))


def step_out(adapter: Adapter, _arguments: Json) -> None:
    """Go to the next place in the caller; from the main routine, go to the next scan."""
    adapter.after_response(lambda: _onward(adapter, adapter.place().depth - 1, by_instruction=True))


def _onward(adapter: Adapter, depth: int | None, *, by_instruction: bool) -> None:
    """Stop at the next place that is not deeper than `depth`; at the end of the scan, in the next one."""
    cursor = adapter.place()
    spot = cursor.onward(depth, by_instruction=by_instruction)
    if spot is not None:
        adapter.go_to(spot)
        adapter.stopped("step")
    elif cursor.scan < adapter.the_subject().extent[1]:
        adapter.look_at(cursor.scan + 1)
        adapter.stopped("step")
    else:
        adapter.the_driver().step()


def step_back(adapter: Adapter, arguments: Json) -> None:
    """Step back to the previous rung or instruction without stepping into routines."""
    by_instruction = _by_instruction(arguments)
    cursor = adapter.place()
    spot = cursor.back(cursor.depth, by_instruction=by_instruction)
    first = adapter.the_subject().extent[0]
    if spot is None and cursor.scan <= first:
        raise DebugError(f"scan {cursor.scan:,} is the first scan: can't step back")

    def move() -> None:
        if spot is None:
            adapter.look_at(cursor.scan - 1, "last")
        else:
            adapter.go_to(spot)
        adapter.stopped("step")

    adapter.after_response(move)


def reverse(adapter: Adapter, _arguments: Json) -> None:
    """Run backward to the previous breakpoint, or to the first scan if there is none."""

    def move() -> None:
        """Search backward, and stop at a breakpoint, where the client pauses, or at the first scan."""
        if adapter.stop_in_scan(backwards=True):
            return
        scan, subject = adapter.place().scan, adapter.the_subject()
        stop_points = adapter.stop_points()
        adapter.leave()  # the search needs the memory that the shown scan uses
        adapter.searching = True
        try:
            stop_scan = subject.last_before(stop_points, scan, adapter.poll) if stop_points else None
        except SearchCanceledError as canceled:
            # the search may have begun before the first scan that can be shown
            adapter.look_at(max(subject.extent[0], canceled.scan), "end")
            adapter.stopped("pause")
            return
        finally:
            adapter.searching = False
        if stop_scan is None:
            adapter.look_at(subject.extent[0])
            adapter.stopped("entry", "no breakpoint before this; this is the first scan")
        else:
            adapter.stop_at_hit(stop_scan, adapter.hits_in(stop_scan), backwards=True)

    adapter.running = True
    adapter.after_response(move)


def _by_instruction(arguments: Json) -> bool:
    granularity = arguments.get("granularity", "line")
    if granularity not in GRANULARITIES:
        raise DebugError(f"granularity {granularity!r}: must be {', '.join(GRANULARITIES)}")
    return bool(granularity == "instruction")
