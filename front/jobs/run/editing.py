"""Edits of the program of a run, between two scans, and their files in its recording."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from ...ladder import LadderLogic
from ...runtime.live.orders import NAMES, Edit
from ...runtime.loop.events import Event, JsonValue
from ...runtime.loop.scan import AttachedLogic, Logic
from ...traces.format.topics import ORDERS
from ...traces.write.recorder import ScanRecorder
from ..load.loading import Job
from ..record.editions import Editions

if TYPE_CHECKING:
    from .running import JobRun

NO_TAGS: Mapping[str, list[str]] = MappingProxyType({"new": [], "changed": [], "dropped": []})


@dataclass(frozen=True, slots=True)
class Edited:
    """An edit of the running program.

    Attributes:
        number: of the edit, from 1.
        at_ns: time of the first scan after it.
        name: of the program.
        text: a sentence about its tags.
        tags: the new ones, those of another type, and those that are gone.
    """

    number: int
    at_ns: int
    name: str
    text: str
    tags: Mapping[str, list[str]]


def edit(run: JobRun, editions: Editions, order: Edit, at_ns: int) -> Edited:
    """Go on with an edited program from the next scan on, and announce that.

    Args:
        run: the run.
        editions: has the program.
        order: which one.
        at_ns: time of the next scan.

    Raises:
        ValueError: it can't be used; the present one goes on.
    """
    job = editions.job(order.number)
    name, text, tags = _take_over(run, job)
    run.cpu.announce(Event(at_ns, "edit", name, text, {**tags}))
    return Edited(order.number, at_ns, name, text, tags)


def _take_over(run: JobRun, job: Job) -> tuple[str, str, Mapping[str, list[str]]]:
    """Let a run go on with the program of a job; return its name, what happened, and the tags concerned."""
    debugger, logic = run.debugger, job.logic
    if debugger is not None and isinstance(logic, LadderLogic):
        done = debugger.edit(logic)
        tags = {"new": list(done.new), "changed": list(done.changed), "dropped": list(done.dropped)}
        return logic.name, str(done), tags
    if debugger is not None or isinstance(logic, LadderLogic):
        raise ValueError(f"{job.program.name}: a program of another kind needs a new session")
    text = f"{job.program.name} is loaded again: the objects of its module are new"
    return job.program.name, text + _replace(run, logic), NO_TAGS


def _replace(run: JobRun, logic: Logic) -> str:
    """Go on with another Python program; return what went wrong at the end of the present one."""
    if isinstance(logic, AttachedLogic):
        logic.__attach_logic__(dict(run.rack.slots))  # refused now; its first scan attaches it for good
    before = run.logic
    run.use(logic)
    try:
        if isinstance(before, AttachedLogic):
            before.__close_logic__()
    except Exception as error:  # of the user's, in a program that has ended
        return f"; at its end the one before raised {type(error).__name__}: {error}"
    return ""


class RecordsEdits:
    """A recorder that attaches the files of an edit ahead of its order; a listener of the scan loop.

    Args:
        recorder: the recorder.
        editions: has the files.
    """

    def __init__(self, recorder: ScanRecorder, editions: Editions) -> None:
        self._recorder, self._editions = recorder, editions
        self.scan = recorder.scan
        self.close = recorder.close

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Record an event."""
        if topic == ORDERS.name and fields["name"] == NAMES[Edit]:
            number = json.loads(str(fields["order"]))["number"]
            self._recorder.attach(scan, self._editions.attachments(number))
        self._recorder.event(scan, now_ns, topic, fields)
