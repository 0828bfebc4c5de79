"""Edits while a rack runs: a saved file is checked beside the scans, and its program replaced between two.

    file      saved
    thread          loaded, built, compiled
    scans     n     n+1   n+2 | n+3            the edited program begins with scan n+3

A ladder program keeps the values of its tags, as in an online edit. A class of Python logic keeps its fields,
and its sequences continue, see `ladder.python.online`; a Python function is loaded again. The page shows a
mistake with its file and line, and the running program continues. A text that a page has edited is previewed,
and saved only when the page takes it over; so is a saved file if the session wants previews. `online` has
edits of rungs in their picture.
An edit is an order of its own, recorded with the program's files: see `jobs.record.program_versions`.
"""

from __future__ import annotations

import json
import threading
import traceback
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from os.path import realpath
from pathlib import Path
from typing import NamedTuple

from ..jobs.load.loading import LoadedRack, load_job
from ..jobs.prove.serving.effects import Group, effects_of
from ..jobs.record.program_versions import ProgramVersion, ProgramVersions, folders_of, forget, version_of
from ..jobs.run.running import JobRun
from ..jobs.trust.attachments import load_files, program_name
from ..ladder import LadderLogic
from ..ladder.python.sequences import Logic
from ..runtime.live.actions import ALL, DRAFT_MOST, Draft, Edit, Online, Source, ToEditor, names_in
from ..runtime.live.session import Reply
from .history.program_file import digest, save, why_not, write
from .online import OnlineEdit
from .preview import Json, findings_of, mistake_of, mistakes_of, new_findings, preview_of

ASKED_MOST = 8
"""Most waiting previews."""

LOOK_S = 0.3
"""Time between two checks of the file."""

Takeover = Callable[[], Edit | None]
"""Returns the order of an edit, or reports a mistake or a preview; called between two scans."""


class EditManner(NamedTuple):
    """How edits are taken."""

    preview: bool = False  # a saved file waits until a page takes it over
    trust: bool = False  # Python that is typed in a page may run


class Exchange(NamedTuple):
    """A program that is to run from the next scan on; another one may have been refused by then."""

    takeover: Takeover
    follow: Callable[[], None] = lambda: None  # called beside the scans when it was carried out, or refused


class Editor:
    """Watches the files of a program, and passes on edited ones.

    Args:
        hand_over: receives a `Takeover`, to be called between two scans.
    """

    def __init__(
        self,
        job: LoadedRack,
        rack: str,
        run: JobRun,
        editions: ProgramVersions,
        hand_over: Callable[[Takeover], None],
        tell: Callable[[Mapping[str, object]], None],
        manner: EditManner,
    ) -> None:
        self._job, self._rack, self._run, self._editions = job, rack, run, editions
        self._hand_over, self._tell, self._manner = hand_over, tell, manner
        self._asked: deque[tuple[ToEditor, Reply]] = deque()
        self._folders: set[Path] = set()  # of copies that were loaded
        self._online = OnlineEdit(program_name(job), self._accepted)
        self._ready: tuple[ProgramVersion, LoadedRack] | None = None  # an accepted program, not used yet
        self._known: tuple[int, LoadedRack, list[Json]] | None = None
        self._exchanging = 0  # exchanges whose outcome has not been followed; of this thread only
        self._exchanged: deque[Exchange] = deque()
        self._ending, self._wake = threading.Event(), threading.Event()
        self._wanted = False
        self._restart = ""
        self._stamp = self._stamped()
        self._disk = self._digest_on_disk()  # of the file as this session has loaded or saved it
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

    def ask(self, order: ToEditor, reply: Reply) -> None:
        """Answer beside the scans: the text of the program, the preview of an edited one, or a step.

        Raises:
            ValueError: too many wait.
        """
        if len(self._asked) >= ASKED_MOST:
            raise ValueError(f"{ASKED_MOST} previews are being made: ask again in a moment")
        self._asked.append((order, reply))
        self._wake.set()

    def _watch(self) -> None:
        while not self._ending.is_set():
            self._wake.wait(LOOK_S)
            self._wake.clear()
            try:
                self._attend()
            except Exception as error:  # a mistake of ours ends no session, and not this thread
                traceback.print_exc()
                mistake = mistake_of(_named(error), self._job.program)
                self._hand_over(partial(self._tell, {"mistake": mistake}))

    def _attend(self) -> None:
        while self._asked:
            self._follow()  # what a page knows from an answer has been followed
            self._answer(*self._asked.popleft())
        self._follow()
        wanted, self._wanted = self._wanted, False
        stamp = self._stamped()
        if stamp is not None and (wanted or stamp != self._stamp):
            self._stamp = stamp
            if self._manner.preview and not wanted:
                self._preview_saved()
            else:
                self._load()

    def _exchange(self, exchange: Exchange) -> None:
        """Hand over an exchange; `_follow` has its outcome."""

        def carried_out() -> None:
            self._exchanged.append(exchange)
            self._wake.set()

        self._exchanging += 1
        self._hand_over(exchange.takeover)
        self._hand_over(carried_out)

    def _follow(self) -> None:
        """Follow what runs after exchanges, and tell the pages."""
        if not self._exchanged:
            return
        while self._exchanged:
            self._exchanging -= 1
            self._exchanged.popleft().follow()
        running = self._running
        self._online.settle(running)
        state = self._online.told(running, self._on_disk())
        self._hand_over(partial(self._tell, {"online": state}))

    def _stamped(self) -> tuple[int, int] | None:
        """Return a version stamp of the file; None while it is missing, empty or half saved."""
        try:
            stat = self._job.program.stat()
        except OSError:
            return None
        return (stat.st_mtime_ns, stat.st_size) if stat.st_size else None

    def _load(self) -> None:
        restart, self._restart = self._restart, ""
        exchange = self._from_disk(restart)
        if self._stamped() == self._stamp:  # otherwise it is being saved: the next check loads it
            self._exchange(exchange)

    def _from_disk(self, restart: str) -> Exchange:
        try:
            job = self._usable(self._loaded(), restart)
            edition = self._editions.with_copy(version_of(job))
        except (ValueError, OSError) as error:
            mistake = mistake_of(error, self._job.program)
            return Exchange(lambda: self._tell({"mistake": mistake}))

        def follow() -> None:
            if self._running.files == edition.files:
                self._disk = digest(edition.files[program_name(self._job)])

        return Exchange(lambda: self._order(edition, job, restart), follow)

    def _order(self, edition: ProgramVersion, job: LoadedRack, restart: str) -> Edit | None:
        """Return the order that continues with a program; None if it already runs."""
        number = self._run.program.edits + 1
        if edition.files == self._editions[number - 1].files and not restart:
            self._tell({"mistake": None})
            self._tell({"note": "The program has not changed: it goes on."})
            return None
        try:
            self._run.program.planned(self._run.cpu, job, names_in(restart))
        except ValueError as error:
            self._tell({"mistake": mistake_of(error, self._job.program)})
            return None
        self._editions.keep(number, edition, job)
        return Edit(number, edition.program, restart)

    def _loaded(self) -> LoadedRack:
        """Load the program from the disk; ValueError if it can't be used."""
        forget([self._job.program.parent.resolve(), *self._folders])
        job = load_job(self._rack)
        if realpath(job.program) != realpath(self._job.program):
            raise ValueError(f"{job.program}: another program needs a new session")
        return job

    def _usable(self, job: LoadedRack, restart: str) -> LoadedRack:
        """Compile a program; ValueError if it can't be used."""
        if isinstance(job.logic, LadderLogic) is (self._run.program.debugger is None):
            raise ValueError(f"{job.program}: a program of another kind needs a new session")
        if isinstance(job.logic, LadderLogic):
            job.logic.build()
            _ = job.logic.scanner  # compiled here, not between two scans
        elif self._job.spec.tags and (ALL in names_in(restart) or not isinstance(job.logic, Logic)):
            raise ValueError(
                f"{job.program}: its values are recorded (tags) and would begin anew: start a new session"
            )
        return job

    # --- edited rungs

    def _step(self, order: Online) -> Callable[[], Json]:
        """Take a step with edited rungs, and hand over the program that it exchanges; return the answer."""
        if self._exchanging:  # what runs then decides whether the step fits
            raise ValueError("the program is being exchanged: ask again in a moment")
        debugger, running = self._run.program.debugger, self._running
        lacks = why_not(self._job.program)
        if debugger is None or lacks:
            raise ValueError(lacks or "the program has no rungs")
        self._online.settle(running)
        stage = self._online.stage
        try:
            wanted = self._online.take(order, running, debugger.program)
            note = self._save(running) if order.step == "save" else ""
            job = self._loaded_version(wanted) if wanted.files != running.files else None
        except Exception:
            self._online.stage = stage
            raise
        state = self._online.told(wanted, self._on_disk())
        if job is not None:
            self._exchange(self._to_version(wanted, job, stage))

        def answer() -> Json:
            if self._running.files != wanted.files:
                raise ValueError(f"{order.step}: the program could not be exchanged: the one before runs")
            self._tell({"online": state})
            if note:
                self._tell({"note": note})
            return state

        return answer

    def _to_version(self, wanted: ProgramVersion, job: LoadedRack, stage: str) -> Exchange:
        """Return an exchange of an edit; the stage is again `stage` if it is refused."""

        def follow() -> None:
            if self._running.files != wanted.files:
                self._online.stage = stage

        own = replace(wanted, retained=None)  # it continues with the values of the one before
        return Exchange(partial(self._order, own, job, ""), follow)

    def _accepted(self, data: bytes) -> ProgramVersion:
        self._ready = self._with(data)
        self._usable(self._ready[1], "")
        return self._ready[0]

    def _loaded_version(self, version: ProgramVersion) -> LoadedRack:
        """Return the program of a version with a copy, which no engine has used yet."""
        ready, self._ready = self._ready, None
        if ready is not None and ready[0] is version:
            return ready[1]
        return self._usable(self._load_copy(version), "")

    def _save(self, running: ProgramVersion) -> str:
        """Write the file of the program that runs; return what became of the old one."""
        program, data = self._job.program, running.files[program_name(self._job)]
        if self._digest_on_disk() != self._disk:
            raise ValueError(f"{program.name} was changed by another program: reload it first")
        if data == self._on_disk():
            return f"{program.name} has these rungs already."
        kept = save(program, data)
        self._stamp, self._disk = self._stamped(), digest(data)
        return f"Saved in {program.name}; the old file is {kept.name}."

    def _on_disk(self) -> bytes | None:
        try:
            return self._job.program.read_bytes()
        except OSError:
            return None

    def _digest_on_disk(self) -> str:
        data = self._on_disk()
        return "" if data is None else digest(data)

    # --- previews

    def _answer(self, order: ToEditor, reply: Reply) -> None:
        """Answer a page between two scans; the work is done here, beside them."""
        then: Exchange | None = None
        try:
            if isinstance(order, Source):
                answer = self._source()
            elif isinstance(order, Online):
                answer = self._step(order)
            else:
                self._check(order)
                answer, then = self._saved(order) if order.take else (self._typed(order), None)
        except Exception as error:
            if not isinstance(error, ValueError | OSError):
                traceback.print_exc()
            answer = _refused(_named(error))

        def give() -> None:
            try:
                told = {"ok": True, **answer()}
            except Exception as error:
                told = {"refused": str(_named(error))}
            reply(told)

        self._hand_over(give)
        if then is not None:
            self._exchange(then)

    def _source(self) -> Callable[[], Json]:
        """Return the text of the file, and whether a page may edit it."""
        text, program = self._saved_text(), self._job.program
        why = ""
        if len(json.dumps(text, ensure_ascii=False).encode()) > DRAFT_MOST:
            why = f"{program.name} is too long: a page edits up to {DRAFT_MOST:,} bytes"
        elif self._run.program.debugger is None and not self._manner.trust:
            why = "a page edits Python only with --trust, since it runs here"
        elif program.suffix not in TYPED_SUFFIXES:
            why = f"a page does not edit {program.suffix} files"
        told = {
            "file": program.name,
            "text": text if not why else "",
            "base": digest(text.encode()),
            "lacks": why,
        }
        return lambda: told

    def _check(self, draft: Draft) -> None:
        """Raise a ValueError if a page may not edit the program, or has not seen what is on the disk."""
        lacks = self._source()()["lacks"]
        if lacks:
            raise ValueError(lacks)
        if digest(self._saved_text().encode()) != draft.base:
            raise ValueError(f"{self._job.program.name} was changed by another program: reload it, then edit")

    def _saved(self, draft: Draft) -> tuple[Callable[[], Json], Exchange]:
        """Save an edited text; return the answer, and what continues with it."""
        data = draft.text.encode()
        write(self._job.program, data)
        self._stamp, self._disk = self._stamped(), digest(data)
        return lambda: {"saved": True}, self._from_disk(draft.restart)

    def _typed(self, draft: Draft) -> Callable[[], Json]:
        load = partial(self._of_text, draft.text)
        return self._previewed(draft.text, draft.restart, load, effects=draft.effects)

    def _preview_saved(self) -> None:
        """Show what a saved file would do; it waits until a page takes it over."""
        show = self._previewed(self._saved_text(), "", self._loaded)

        def tell() -> None:
            shown = show()["preview"]
            self._tell({"preview": shown if shown["rows"] else None})

        self._hand_over(tell)

    def _previewed(
        self, text: str, restart: str, load: Callable[[], LoadedRack], *, effects: bool = True
    ) -> Callable[[], Json]:
        """Load an edited text; return what previews it between two scans."""
        program, texts = self._job.program, (self._running_text(), text)
        try:
            job = self._usable(load(), restart)
            running, known = self._known_version()
            findings = new_findings(findings_of(job), known)
            changes = _effects(running, job) if effects else ()
        except (ValueError, OSError) as error:
            refused = preview_of(program, texts, mistakes=mistakes_of(error, program))
            return lambda: {"preview": refused}

        def shown() -> Json:
            try:
                edit = self._run.program.planned(self._run.cpu, job, names_in(restart))
            except ValueError as error:
                return {"preview": preview_of(program, texts, mistakes=mistakes_of(error, program))}
            return {"preview": preview_of(program, texts, edit=edit, findings=findings, effects=changes)}

        return shown

    def _of_text(self, text: str) -> LoadedRack:
        """Load the running files with another text of the program, from a copy of them."""
        return self._with(text.encode())[1]

    def _with(self, data: bytes) -> tuple[ProgramVersion, LoadedRack]:
        """Return the running version with other contents of the program's file, and load it."""
        edition = self._running
        files = {**edition.files, program_name(self._job): data}
        copy = self._editions.with_copy(replace(edition, files=files, retained=None))
        return copy, self._load_copy(copy)

    def _load_copy(self, copy: ProgramVersion) -> LoadedRack:
        assert copy.place is not None
        forget([self._job.program.parent.resolve(), *self._folders])
        job = load_files(copy.place, copy.rack, copy.program)
        self._folders |= folders_of(job)
        return job

    @property
    def _running(self) -> ProgramVersion:
        return self._editions[self._run.program.edits]

    def _running_text(self) -> str:
        return self._running.files[program_name(self._job)].decode(errors="replace")

    def _saved_text(self) -> str:
        """Return the text on the disk; ValueError if it is not UTF-8."""
        with self._job.program.open(encoding="utf-8", newline="") as file:
            return file.read()

    def _known_version(self) -> tuple[LoadedRack, list[Json]]:
        """Return the program that runs, loaded again, and its findings."""
        number = self._run.program.edits
        if self._known is None or self._known[0] != number:
            job = self._of_text(self._running_text())
            self._known = number, job, findings_of(job)
        return self._known[1:]


TYPED_SUFFIXES = (".rung", ".st", ".py")
"""Suffixes of programs that a page edits."""


def _effects(running: LoadedRack, edited: LoadedRack) -> tuple[Group, ...]:
    """Return what an edit of rungs can change."""
    if not isinstance(running.logic, LadderLogic) or not isinstance(edited.logic, LadderLogic):
        return ()
    return effects_of(running.logic, edited.logic)


def _named(error: Exception) -> Exception:
    """Return what pages are told of an error; one that no rule makes has its type."""
    if isinstance(error, ValueError | OSError):
        return error
    return ValueError(f"it can't be carried out: {type(error).__name__}: {error}")


def _refused(error: Exception) -> Callable[[], Json]:
    def refuse() -> Json:
        raise ValueError(str(error))

    return refuse
