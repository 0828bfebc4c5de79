"""Edits while a rack runs: a saved file is checked beside the scans, and its program replaced between two.

    file      saved
    thread          loaded, built, compiled
    scans     n     n+1   n+2 | n+3            the edited program begins with scan n+3

A ladder program keeps the values of its tags, as in an online edit. A class of Python logic keeps its fields,
and its sequences continue, see `ladder.python.online`; a Python function is loaded again. The page shows a
mistake with its file and line, and the running program continues.
An edit is an order of its own, recorded with the program's files: see `jobs.record.editions`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from os.path import realpath
from pathlib import Path
from typing import Any

from ..io_images.site import sites_of
from ..jobs.load.loading import Job, load_job
from ..jobs.record.editions import Edition, Editions, edition_of
from ..jobs.run.running import JobRun
from ..jobs.trust.attachments import forget_imported
from ..ladder import LadderLogic
from ..ladder.python.online import EditRefusal
from ..ladder.python.sequences import Logic
from ..runtime.live.orders import ALL, Edit, names_in

LOOK_S = 0.3
"""Time between two checks of the file."""

Json = dict[str, Any]
Takeover = Callable[[], Edit | None]
"""Returns the order of an edit, or reports a mistake; called between two scans."""


class Editor:
    """Watches the files of a program, and passes on edited ones.

    Args:
        hand_over: receives a `Takeover`, to be called between two scans.
    """

    def __init__(
        self,
        job: Job,
        rack: str,
        run: JobRun,
        editions: Editions,
        hand_over: Callable[[Takeover], None],
        tell: Callable[[Mapping[str, object]], None],
    ) -> None:
        self._job, self._rack, self._run, self._editions = job, rack, run, editions
        self._hand_over, self._tell = hand_over, tell
        self._ending, self._wake = threading.Event(), threading.Event()
        self._wanted = False
        self._restart = ""
        self._stamp = self._stamped()
        self._thread = threading.Thread(target=self._watch, name="edits", daemon=True)

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def end(self) -> None:
        """End the thread."""
        self._ending.set()
        self._wake.set()
        self._thread.join()

    def load_soon(self, restart: str = "") -> None:
        """Load the program's present version beside the scans; `restart` as in an order."""
        self._restart, self._wanted = restart, True
        self._wake.set()

    def _watch(self) -> None:
        while not self._ending.is_set():
            self._wake.wait(LOOK_S)
            self._wake.clear()
            wanted, self._wanted = self._wanted, False
            stamp = self._stamped()
            if stamp is not None and (wanted or stamp != self._stamp):
                self._stamp = stamp
                self._load()

    def _stamped(self) -> tuple[int, int] | None:
        """Return a version stamp of the file; None while it is missing, empty or half saved."""
        try:
            stat = self._job.program.stat()
        except OSError:
            return None
        return (stat.st_mtime_ns, stat.st_size) if stat.st_size else None

    def _load(self) -> None:
        restart, self._restart = self._restart, ""
        takeover = self._takeover(restart)
        if self._stamped() == self._stamp:  # otherwise it is being saved: the next check loads it
            self._hand_over(takeover)

    def _takeover(self, restart: str) -> Takeover:
        try:
            job = self._loaded(restart)
            edition = self._editions.with_copy(edition_of(job))
        except (ValueError, OSError) as error:
            mistake = mistake_of(error, self._job.program)
            return lambda: self._tell({"mistake": mistake})
        return lambda: self._order(edition, job, restart)

    def _order(self, edition: Edition, job: Job, restart: str) -> Edit | None:
        """Return the order that continues with a program; None if it already runs."""
        number = self._run.program.edits + 1
        if edition.files == self._editions[number - 1].files and not restart:
            self._tell({"mistake": None})
            self._tell({"note": "The program has not changed: it goes on."})
            return None
        try:
            self._run.program.check_edit(self._run.cpu, job, names_in(restart))
        except ValueError as error:
            self._tell({"mistake": mistake_of(error, self._job.program)})
            return None
        self._editions.keep(number, edition, job)
        return Edit(number, edition.program, restart)

    def _loaded(self, restart: str) -> Job:
        """Load the program and compile it; ValueError if it can't be used."""
        forget_imported(self._job.program.parent.resolve())
        job = load_job(self._rack)
        if isinstance(job.logic, LadderLogic) is (self._run.program.debugger is None):
            raise ValueError(f"{job.program}: a program of another kind needs a new session")
        if realpath(job.program) != realpath(self._job.program):
            raise ValueError(f"{job.program}: another program needs a new session")
        if isinstance(job.logic, LadderLogic):
            job.logic.build()
            _ = job.logic.scanner  # compiled here, not between two scans
        elif self._job.spec.tags and (ALL in names_in(restart) or not isinstance(job.logic, Logic)):
            raise ValueError(
                f"{job.program}: its values are recorded (tags) and would begin anew: start a new session"
            )
        return job


def mistake_of(error: Exception, program: Path) -> Json:
    """Return a mistake for a page: its text, the program's file, and its line if that is known.

    >>> from scanrack.io_images.site import Site, SiteError
    >>> mistake_of(SiteError.at(Site(file="demo.rung", line=12), "there is no tag Rum"), Path("demo.rung"))
    {'text': 'demo.rung:12: there is no tag Rum', 'file': 'demo.rung', 'line': 12}
    """
    lines = (each.line for each in sites_of(error) if Path(each.file).name == program.name)
    line = next(filter(None, lines), None)
    restarts = {"restart": list(error.sequences)} if isinstance(error, EditRefusal) else {}
    return {"text": str(error), "file": program.name, "line": line, **restarts}
