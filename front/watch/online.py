"""Edited rungs beside the running program, as in Studio 5000: accepted, tested, assembled, saved.

    step       from                 to         runs afterwards
    accept     -, accepted          accepted   as before; the edited program is checked and loaded beside it
    test       accepted             testing    the edited one
    untest     testing              accepted   the one before
    assemble   accepted, testing    assembled  the edited one
    reopen     assembled            testing    the edited one: assembling is undone
    cancel     accepted, testing    -          the one before
    save       -, assembled         -          the same; its file is written, the old file is kept

A step that exchanges the program is an `Edit` with all its files: a recording is repeated with the same
programs in the same scans.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from ..jobs.record.program_versions import ProgramVersion
from ..ladder import LadderLogic
from ..ladder.lowering.edited import NewTag, RungEdit
from ..ladder.lowering.text import parse_rung
from ..runtime.live.actions import Online
from .history.program_file import digest, rewrite

Json = dict[str, Any]

NOTHING, ACCEPTED, TESTING, ASSEMBLED = "", "accepted", "testing", "assembled"


class Move(NamedTuple):
    """A step: the stages from which it is taken, the next one, and whether the edited program runs in it."""

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
}
"""The steps by name, see above."""


class Pair(NamedTuple):
    """The programs of an edit."""

    before: ProgramVersion
    edited: ProgramVersion


class OnlineEdit:
    """The edited rungs of a session.

    Args:
        name: of the program's file among the files of a version.
        load: makes a version with other contents of that file, and loads it; ValueError if it can't be used.
    """

    def __init__(self, name: str, load: Callable[[bytes], ProgramVersion]) -> None:
        self._name, self._load = name, load
        self.stage = NOTHING
        self._pair: Pair | None = None

    def take(self, order: Online, running: ProgramVersion, program: LadderLogic) -> ProgramVersion:
        """Take a step; return the version that runs from now on.

        Args:
            order: the step.
            running: the version that runs now, which `settle` has followed.
            program: its program.

        Raises:
            ValueError: the step does not fit the stage, or the edited program can't be used.
        """
        move = MOVES[order.step]
        if self.stage not in move.sources:
            raise ValueError(f"{order.step}: {_SAYS[self.stage]}")
        if order.step == "accept":
            self._pair = Pair(running, self._load(self._edited(running, program, order)))
        self.stage = move.stage
        if self._pair is None or order.step == "save":
            return running
        return self._pair.edited if move.runs_edited else self._pair.before

    def settle(self, running: ProgramVersion) -> None:
        """Follow what runs: a step that was refused, or another edit."""
        if self._pair is None:
            return
        if running.files == self._pair.before.files:
            self.stage = ACCEPTED if self.stage in (TESTING, ASSEMBLED) else self.stage
        elif running.files != self._pair.edited.files or self.stage == NOTHING:
            self.stage, self._pair = NOTHING, None

    def told(self, running: ProgramVersion, on_disk: bytes | None) -> Json:
        """Return the state for pages; `on_disk` is the program's file."""
        data = running.files[self._name]
        return {"stage": self.stage, "base": digest(data), "unsaved": on_disk not in (None, data)}

    def _edited(self, before: ProgramVersion, program: LadderLogic, order: Online) -> bytes:
        """Return the file of the running program with the edits of an order."""
        data = before.files[self._name]
        if digest(data) != order.base:
            raise ValueError("the program was edited meanwhile: edit the one that runs now")
        if not order.rungs:
            raise ValueError("no rung is edited")
        edits = [
            RungEdit(routine, number, tuple(str(parse_rung(each, specs=program.specs)) for each in texts))
            for routine, number, texts in order.rungs
        ]
        return rewrite(self._name, data, edits, [NewTag(*each) for each in order.tags])


_SAYS = {
    NOTHING: "no edit has been accepted",
    ACCEPTED: "the edit is accepted, and does not run: test, assemble or cancel it",
    TESTING: "the edit is being tested: untest, assemble or cancel it",
    ASSEMBLED: "the edit is assembled already",
}
