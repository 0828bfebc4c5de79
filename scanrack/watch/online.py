"""Online edits of rungs, as in Studio 5000: they are accepted, tested, assembled and saved.

    step       from                    to         program that runs afterwards
    accept     -, accepted, assembled  accepted   unchanged; the edited one is checked and loaded beside it
    test       accepted                testing    the edited one
    untest     testing                 accepted   the previous one
    assemble   accepted, testing       assembled  the edited one
    reopen     assembled               testing    the edited one; assembling is undone
    cancel     accepted, testing       -          the previous one
    save       -, assembled            -          unchanged; its file is written, the old file is kept
    try        any                     testing    the program's file, saved in an editor
    take       any                     assembled  the program's file, saved in an editor

There is a single accepted edit, whoever accepted it; the state has its rungs and its page. A step states in
`base` what its page has seen: for accept and save, the running program; for the others, the edit. The step is
refused if these have changed since.

A step that replaces the program is recorded as an `Edit` with all its files, so that a recording is repeated
with the same programs in the same scans.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.record.program_versions import ProgramVersion, version_of
from scanrack.ladder.lowering.edited import FileChange, NewTag, normalized
from scanrack.runtime.live.actions import Online

from .edited_programs import EditedPrograms
from .history.program_file import digest, read_edit, rewrite, why_not

Json = dict[str, Any]

MOST_CHANGES = 20
"""Largest number of changed elements that a note lists."""

NOTHING, ACCEPTED, TESTING, ASSEMBLED = "", "accepted", "testing", "assembled"


class Move(NamedTuple):
    """A step: the stages in which it is allowed, the next stage, and whether the edited program then runs."""

    sources: tuple[str, ...]
    stage: str
    runs_edited: bool


MOVES: Mapping[str, Move] = {
    "accept": Move((NOTHING, ACCEPTED, ASSEMBLED), ACCEPTED, False),
    "test": Move((ACCEPTED,), TESTING, True),
    "untest": Move((TESTING,), ACCEPTED, False),
    "assemble": Move((ACCEPTED, TESTING), ASSEMBLED, True),
    "reopen": Move((ASSEMBLED,), TESTING, True),
    "cancel": Move((ACCEPTED, TESTING), NOTHING, False),
    "save": Move((NOTHING, ASSEMBLED), NOTHING, True),
    "try": Move((NOTHING, ACCEPTED, TESTING, ASSEMBLED), TESTING, True),
    "take": Move((NOTHING, ACCEPTED, TESTING, ASSEMBLED), ASSEMBLED, True),
}
"""The steps by name, see the module."""

OF_FILE = ("try", "take")
"""Steps with the program's file as saved by an editor; pages do not take them."""


class AcceptedEdit(NamedTuple):
    """The accepted draft of an edit, and its programs."""

    draft: Online
    before: ProgramVersion
    edited: ProgramVersion
    changes: str  # names of the elements that changed in the file, with reasons


class Step(NamedTuple):
    """The effects of a step: the version to run, and the previous state."""

    version: ProgramVersion
    job: LoadedRack | None  # its program, not yet used by an engine; None if it already runs
    note: str
    stage: str
    edit: AcceptedEdit | None


class OnlineEdit:
    """The edited rungs of a session.

    Attributes:
        stage: stage of the edit; "" without an edit.
        edit: the accepted edit; None if there is none.
    """

    def __init__(self, programs: EditedPrograms) -> None:
        self._programs = programs
        self.stage = NOTHING
        self.edit: AcceptedEdit | None = None
        self._ready: tuple[ProgramVersion, LoadedRack] | None = None  # an accepted program, not yet used

    def take(self, order: Online) -> Step:
        """Take a step.

        Raises:
            ValueError: the step does not fit the stage or the page's base, or the edited program can't be
                used; nothing has changed.
            OSError: a file can't be written; nothing has changed.
        """
        self.settle()
        move, running, edit, note = MOVES[order.step], self._programs.running, self.edit, ""
        self._check_allowed(order, running)
        if order.step == "accept":
            edit = self._accepted(order, running)
            note = edit.changes
        elif order.step in OF_FILE:
            edit = self._from_file(order, running)
        version = running
        if order.step == "save":
            note = self._programs.save_running()
        elif edit is not None:
            version = edit.edited if move.runs_edited else edit.before
        job = None if version.files == running.files else self._job_of(version)
        step = Step(replace(version, retained=None), job, note, self.stage, self.edit)
        self.stage, self.edit = move.stage, edit if move.stage else None
        return step

    def undo(self, step: Step) -> None:
        """Return to the state before a step whose program could not be used."""
        self.stage, self.edit = step.stage, step.edit

    def settle(self) -> None:
        """Adapt to the running program after a refused step or another edit."""
        if self.edit is None:
            return
        files, runs_edited = self._programs.running.files, self.stage in (TESTING, ASSEMBLED)
        if files == self.edit.before.files:
            self.stage = ACCEPTED
        elif files != self.edit.edited.files or not runs_edited:
            self.stage, self.edit = NOTHING, None

    def state(self, running: ProgramVersion) -> Json:
        """Return the state for pages, given the version that now runs."""
        data, on_disk = running.files[self._programs.name], self._programs.on_disk
        state: Json = {"stage": self.stage, "base": digest(data), "unsaved": on_disk != data}
        if self.edit is not None:
            draft = self.edit.draft
            state |= {"edit": self._digest(self.edit.edited), "of": self._digest(self.edit.before)}
            state |= {"by": draft.by, "rungs": draft.rungs, "tags": draft.tags}
        return state

    def _digest(self, version: ProgramVersion) -> str:
        return digest(version.files[self._programs.name])

    def _check_allowed(self, order: Online, running: ProgramVersion) -> None:
        """Raise ValueError if a step does not fit, or its page has seen another program or edit."""
        lacks = "" if order.step in OF_FILE else why_not(self._programs.file)
        if lacks or self._programs.rungs is None:
            raise ValueError(lacks or "the program has no rungs: reload it")
        if self.stage not in MOVES[order.step].sources:
            raise ValueError(f"{order.step}: {_SAYS[self.stage]}")
        self._check_seen(order, running)

    def _check_seen(self, order: Online, running: ProgramVersion) -> None:
        """Raise ValueError if the page of a step has seen another program or edit."""
        if order.step in ("accept", "save"):
            if (order.base or order.step == "accept") and order.base != self._digest(running):
                raise ValueError("the program was edited meanwhile: edit the one that runs now")
        elif self.edit is not None and order.base not in ("", self._digest(self.edit.edited)):
            by = self.edit.draft.by or "another page"
            raise ValueError(f"{order.step}: {by} has accepted another edit meanwhile: look at it first")

    def _accepted(self, order: Online, running: ProgramVersion) -> AcceptedEdit:
        """Load the running program with the edits of an order, beside the original."""
        program = self._programs.rungs
        assert program is not None
        if not order.rungs:
            raise ValueError("no rung is edited")
        name, specs = self._programs.name, program.specs
        edits = [normalized(read_edit(name, rung, specs), program) for rung in order.rungs]
        data = running.files[name]
        rewritten = rewrite(name, data, edits, [NewTag(*tag) for tag in order.tags], specs)
        if rewritten.data == data:
            raise ValueError("the edited rungs are those that run")
        version, job = self._programs.with_file(rewritten.data)
        self._ready = version, self._programs.usable(job)
        return AcceptedEdit(order, running, version, _listed(rewritten.changes))

    def _from_file(self, order: Online, running: ProgramVersion) -> AcceptedEdit:
        """Load the saved file beside the running program."""
        programs = self._programs
        programs.look()
        job = programs.usable(programs.from_disk())
        version = programs.versions.with_copy(version_of(job))
        before = running if self.edit is None or self.stage == ASSEMBLED else self.edit.before
        if version.files == before.files:
            raise ValueError(f"{programs.file.name} has the rungs that run: edit and save it first")
        programs.seen, self._ready = digest(version.files[programs.name]), (version, job)
        return AcceptedEdit(order, before, version, "")

    def _job_of(self, version: ProgramVersion) -> LoadedRack:
        """Return the program of a version, not yet used by an engine."""
        prepared, self._ready = self._ready, None
        if prepared is not None and prepared[0] is version:
            return prepared[1]
        return self._programs.usable(self._programs.load(version))


def _listed(changes: Sequence[FileChange]) -> str:
    """Return the changed elements of a file as text; "" for a single one."""
    if len(changes) < 2:
        return ""
    shown_changes = [f"{change.element}: {change.why}" for change in changes[:MOST_CHANGES]]
    hidden = len(changes) - len(shown_changes)
    return "; ".join((*shown_changes, f"and {hidden} more") if hidden else shown_changes)


_SAYS = {
    NOTHING: "no edit has been accepted",
    ACCEPTED: "the edit is accepted, and does not run: test, assemble or cancel it",
    TESTING: "the edit is being tested: untest, assemble or cancel it",
    ASSEMBLED: "the edit is assembled already",
}
