"""Online edits of rungs, as in Studio 5000: accept, test, assemble and save.

    step       from                    to         program that runs after the step
    accept     -, accepted, assembled  accepted   unchanged; the edited one is checked and loaded
    test       accepted                testing    the edited one
    untest     testing                 accepted   the previous one
    assemble   accepted, testing       assembled  the edited one
    reopen     assembled               testing    the edited one; undoes assemble
    cancel     accepted, testing       -          the previous one
    save       -, assembled            -          unchanged; its file is written, with a backup
    try        any                     testing    the program's file, saved in an editor
    take       any                     assembled  the program's file, saved in an editor

All pages share one accepted edit; the state has its rungs and the page that accepted it. The `base` of a step
is the digest that its page has seen: of the running program for accept and save, otherwise of the edit. The
step is refused if the program or the edit has changed since.

A step that replaces the program is recorded as an `Edit` with all files, so that a replay of the trace runs
the same programs in the same scans.
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
from .history.program_file import digest, read_edit, rewrite, why_not_editable

Json = dict[str, Any]

MOST_CHANGES = 20
"""Maximum number of changed elements in a note."""

NOTHING, ACCEPTED, TESTING, ASSEMBLED = "", "accepted", "testing", "assembled"


class Move(NamedTuple):
    """A row of the table of steps."""

    sources: tuple[str, ...]  # the stages in which the step is allowed
    stage: str  # the next stage
    runs_edited: bool  # whether the edited program runs after the step


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
"""The steps by name, as in the table of the module."""

FILE_STEPS = ("try", "take")
"""Steps that use the program's file as saved in an editor. Pages do not use them."""


class AcceptedEdit(NamedTuple):
    """An accepted edit."""

    draft: Online
    original: ProgramVersion
    edited: ProgramVersion
    changes: str  # the elements that changed in the file, with reasons; "" for a single one


class Step(NamedTuple):
    """A completed step, with the previous state for `OnlineEdit.undo`."""

    version: ProgramVersion  # the version that runs after the step
    job: LoadedRack | None  # its program, which no engine has used yet; None if it already runs
    note: str
    stage: str  # the stage before the step
    edit: AcceptedEdit | None  # the edit before the step


class OnlineEdit:
    """The online edit of a session.

    Attributes:
        stage: stage of the edit; "" without an edit.
        edit: the accepted edit, or None.
    """

    def __init__(self, programs: EditedPrograms) -> None:
        self._programs = programs
        self.stage = NOTHING
        self.edit: AcceptedEdit | None = None
        self._ready: tuple[ProgramVersion, LoadedRack] | None = None  # the accepted program until it is used

    def take(self, action: Online) -> Step:
        """Perform a step.

        Raises:
            ValueError: the stage or the page's base does not allow the step, or the edited program can't be
                used; nothing has changed.
            OSError: a file can't be written; nothing has changed.
        """
        self.settle()
        move, running, edit, note = MOVES[action.step], self._programs.running, self.edit, ""
        self._check_allowed(action, running)
        if action.step == "accept":
            edit = self._accepted(action, running)
            note = edit.changes
        elif action.step in FILE_STEPS:
            edit = self._from_file(action, running)
        version = running
        if action.step == "save":
            note = self._programs.save_running()
        elif edit is not None:
            version = edit.edited if move.runs_edited else edit.original
        job = None if version.files == running.files else self._job_of(version)
        step = Step(replace(version, retained=None), job, note, self.stage, self.edit)
        self.stage, self.edit = move.stage, edit if move.stage else None
        return step

    def undo(self, step: Step) -> None:
        """Undo a step whose program could not replace the running program."""
        self.stage, self.edit = step.stage, step.edit

    def settle(self) -> None:
        """Adapt the stage to the running program, after a refused step or another edit."""
        if self.edit is None:
            return
        files, runs_edited = self._programs.running.files, self.stage in (TESTING, ASSEMBLED)
        if files == self.edit.original.files:
            self.stage = ACCEPTED
        elif files != self.edit.edited.files or not runs_edited:
            self.stage, self.edit = NOTHING, None

    def state(self, running: ProgramVersion) -> Json:
        """Return the state for pages while a version runs."""
        data, on_disk = running.files[self._programs.name], self._programs.on_disk
        state: Json = {"stage": self.stage, "base": digest(data), "unsaved": on_disk != data}
        if self.edit is not None:
            draft = self.edit.draft
            state |= {"edit": self._digest(self.edit.edited), "of": self._digest(self.edit.original)}
            state |= {"by": draft.by, "rungs": draft.rungs, "tags": draft.tags}
        return state

    def _digest(self, version: ProgramVersion) -> str:
        return digest(version.files[self._programs.name])

    def _check_allowed(self, action: Online, running: ProgramVersion) -> None:
        """Raise ValueError if a step is not allowed now."""
        obstacle = "" if action.step in FILE_STEPS else why_not_editable(self._programs.file)
        if obstacle or self._programs.rungs is None:
            raise ValueError(obstacle or "the program has no rungs; reload the page")
        if self.stage not in MOVES[action.step].sources:
            raise ValueError(f"{action.step}: {_STAGE_TEXTS[self.stage]}")
        self._check_seen(action, running)

    def _check_seen(self, action: Online, running: ProgramVersion) -> None:
        """Raise ValueError if the program or edit has changed since the step's page last saw it."""
        if action.step in ("accept", "save"):
            if (action.base or action.step == "accept") and action.base != self._digest(running):
                raise ValueError("the program has changed meanwhile; edit the one that runs now")
        elif self.edit is not None and action.base not in ("", self._digest(self.edit.edited)):
            page = self.edit.draft.by or "another page"
            raise ValueError(f"{action.step}: {page} has accepted another edit meanwhile; check it first")

    def _accepted(self, action: Online, running: ProgramVersion) -> AcceptedEdit:
        """Load the running program with the rungs of an accept step."""
        program = self._programs.rungs
        assert program is not None
        if not action.rungs:
            raise ValueError("no rung is edited")
        name, specs = self._programs.name, program.specs
        edits = [normalized(read_edit(name, rung, specs), program) for rung in action.rungs]
        data = running.files[name]
        rewritten = rewrite(name, data, edits, [NewTag(*tag) for tag in action.tags], specs)
        if rewritten.data == data:
            raise ValueError("the edited rungs are the same as the running ones")
        version, job = self._programs.with_file(rewritten.data)
        self._ready = version, self._programs.usable(job)
        return AcceptedEdit(action, running, version, _listed(rewritten.changes))

    def _from_file(self, action: Online, running: ProgramVersion) -> AcceptedEdit:
        """Load the program's file as saved in an editor."""
        programs = self._programs
        programs.look()
        job = programs.usable(programs.from_disk())
        version = programs.versions.with_copy(version_of(job))
        original = running if self.edit is None or self.stage == ASSEMBLED else self.edit.original
        if version.files == original.files:
            raise ValueError(f"{programs.file.name} has the rungs that run; edit and save it first")
        programs.seen, self._ready = digest(version.files[programs.name]), (version, job)
        return AcceptedEdit(action, original, version, "")

    def _job_of(self, version: ProgramVersion) -> LoadedRack:
        """Return the program of a version for the engine; load it if it is not ready."""
        prepared, self._ready = self._ready, None
        if prepared is not None and prepared[0] is version:
            return prepared[1]
        return self._programs.usable(self._programs.load(version))


def _listed(changes: Sequence[FileChange]) -> str:
    """Return text with the changed elements of a file and the reasons; "" for a single element."""
    if len(changes) < 2:
        return ""
    shown_changes = [f"{change.element}: {change.why}" for change in changes[:MOST_CHANGES]]
    hidden = len(changes) - len(shown_changes)
    return "; ".join((*shown_changes, f"and {hidden} more") if hidden else shown_changes)


_STAGE_TEXTS = {
    NOTHING: "no edit has been accepted",
    ACCEPTED: "the edit is accepted and does not run; test, assemble or cancel it",
    TESTING: "the edit is being tested; untest, assemble or cancel it",
    ASSEMBLED: "the edit is already assembled",
}
