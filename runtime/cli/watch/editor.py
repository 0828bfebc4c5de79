"""Edits while a rack runs: the program's file is saved, checked beside the scans, and taken over between two.

    file      saved
    thread          loaded, built, compiled
    scans     n     n+1   n+2 | n+3            the edited program begins with scan n+3

A ladder program keeps the values of its tags, as in an online edit. A Python program is loaded again: objects
of its module begin again. The page shows a mistake with its file and line, and the running program goes on.
"""

from __future__ import annotations

import hashlib
import re
import threading
from collections.abc import Callable, Mapping
from os.path import realpath
from pathlib import Path
from typing import Any

from ....ladder import LadderLogic
from ....ladder.debug import Debugger
from ...app.attachments import forget_imported
from ...app.loading import Job, load_job
from ...app.running import JobRun
from ...loop.events import Event

LOOK_S = 0.3
"""Time between two looks at the file."""

Json = dict[str, Any]
Takeover = Callable[[int], bool]
"""Goes on with an edited program (True), or reports a mistake; called with the next scan's time."""


class Editor:
    """Watches the files of a program, and passes on edited ones.

    Args:
        job: what runs.
        rack: path of the rack file.
        run: its run.
        hand_over: takes what goes on with an edited program, to be called between two scans.
        tell: takes messages for the monitor.
    """

    def __init__(
        self,
        job: Job,
        rack: str,
        run: JobRun,
        hand_over: Callable[[Takeover], None],
        tell: Callable[[Mapping[str, object]], None],
    ) -> None:
        self._job, self._rack, self._run = job, rack, run
        self._hand_over, self._tell = hand_over, tell
        self._ending = threading.Event()
        self._stamp = self._stamped()
        self._thread = threading.Thread(target=self._watch, name="edits", daemon=True)

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def end(self) -> None:
        """End it."""
        self._ending.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._ending.wait(LOOK_S):
            stamp = self._stamped()
            if stamp != self._stamp and stamp is not None:
                self._stamp = stamp
                self.load()

    def _stamped(self) -> tuple[int, int] | None:
        """Return what differs between versions of a file; None while there is no file."""
        try:
            stat = self._job.program.stat()
        except OSError:
            return None
        return stat.st_mtime_ns, stat.st_size

    def load(self) -> None:
        """Load the program, and pass it on or report the mistake."""
        try:
            job = self._loaded()
        except ValueError as error:
            mistake = mistake_of(str(error), self._job.program)
            self._hand_over(lambda _at_ns: self._tell_mistake(mistake))
            return
        self._hand_over(lambda at_ns: self._take_over(job, at_ns))

    def _tell_mistake(self, mistake: Json) -> bool:
        self._tell({"mistake": mistake})
        return False

    def _loaded(self) -> Job:
        """Load the program and compile it.

        Raises:
            ValueError: it can't be used.
        """
        forget_imported(self._job.program.parent.resolve())
        job = load_job(self._rack)
        if isinstance(job.logic, LadderLogic) is not isinstance(self._run.logic, Debugger):
            raise ValueError(f"{job.program}: a program of another kind needs a new session")
        if realpath(job.program) != realpath(self._job.program):
            raise ValueError(f"{job.program}: another program needs a new session")
        if isinstance(job.logic, LadderLogic):
            job.logic.build()
            _ = job.logic.scanner  # compiled here, not between two scans
        elif self._job.spec.tags:
            raise ValueError(
                f"{job.program}: values of a Python program are recorded (tags): an edit needs a new session"
            )
        return job

    def _take_over(self, job: Job, at_ns: int) -> bool:
        """Go on with a program, between two scans."""
        fields: dict[str, list[str]] = {"new": [], "changed": [], "dropped": []}
        name = job.program.name
        if isinstance(job.logic, LadderLogic) and isinstance(self._run.logic, Debugger):
            edit = self._run.logic.edit(job.logic)
            fields = {"new": list(edit.new), "changed": list(edit.changed), "dropped": list(edit.dropped)}
            text, name = str(edit), job.logic.name
        else:
            self._run.use(job.logic)
            text = f"{name} is loaded again: the objects of its module are new"
        self._run.cpu.announce(Event(at_ns, "edit", name, text, {**fields}))
        sha = hashlib.sha256(job.program.read_bytes()).hexdigest()
        self._tell({"edited": {"text": text, "sha256": sha, "edits": self._run.edits, **fields}})
        return True


def mistake_of(text: str, program: Path) -> Json:
    """Return a mistake as a page shows it: its text, file and line, as far as the text names them.

    >>> mistake_of("demo.rung:12: there is no tag Rum", Path("demo.rung"))
    {'text': 'demo.rung:12: there is no tag Rum', 'file': 'demo.rung', 'line': 12}
    """
    found = re.search(rf"{re.escape(program.name)}:(\d+)", text)
    line = None if found is None else int(found[1])
    return {"text": text, "file": program.name, "line": line}
