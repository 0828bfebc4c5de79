"""Edits of a program's text on a page: the programs that a page may edit, and the preview of an edit."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.prove.serving.effects import Group, effects_of
from scanrack.jobs.run.running import JobRun
from scanrack.ladder import LadderLogic
from scanrack.runtime.live.actions import DRAFT_MOST, Draft, names_in

from .edited_programs import EditedPrograms
from .history.program_file import digest
from .preview import Json, findings_of, mistakes_of, new_findings, preview_of

TYPED_SUFFIXES = (".rung", ".st", ".py")
"""Suffixes of programs that a page can edit."""

Answer = Callable[[], Json]
"""A function called between two scans, which returns the answer for a page or raises ValueError to refuse."""


class TypedText:
    """Edits of the text of a program.

    Args:
        trust: whether Python that is typed on a page may run.
    """

    def __init__(self, programs: EditedPrograms, run: JobRun, *, trust: bool) -> None:
        self._programs, self._run, self._trust = programs, run, trust

    def source(self) -> Json:
        """Return the text of the file, and why a page may not edit it; raise OSError if it can't be read."""
        text, program, obstacle = self._programs.saved_text(), self._programs.file, ""
        if len(json.dumps(text, ensure_ascii=False).encode()) > DRAFT_MOST:
            obstacle = f"{program.name} is too long: a page can edit up to {DRAFT_MOST:,} bytes"
        elif self._programs.rungs is None and not self._trust:
            obstacle = "a page can edit Python only with --trust, since it runs on this machine"
        elif program.suffix not in TYPED_SUFFIXES:
            obstacle = f"a page can't edit {program.suffix} files"
        base = digest(text.encode())
        return {"file": program.name, "text": "" if obstacle else text, "base": base, "lacks": obstacle}

    def check(self, draft: Draft) -> None:
        """Raise ValueError if a page may not edit the program, or its draft has a different base."""
        source = self.source()
        if source["lacks"]:
            raise ValueError(source["lacks"])
        if source["base"] != draft.base:
            raise ValueError(f"{source['file']} was changed by another program; reload it, then edit")

    def preview(self, draft: Draft) -> Answer:
        """Load an edited text with a copy of the running files; return a function that previews it."""
        data = draft.text.encode()
        load = lambda: self._programs.with_file(data)[1]  # noqa: E731
        return self._previewed(draft.text, draft.restart, load, effects=draft.effects)

    def preview_saved(self) -> Answer:
        """Load the text that another program has saved; return a function that creates its preview."""
        return self._previewed(self._programs.saved_text(), "", self._programs.from_disk, effects=True)

    def _previewed(self, text: str, restart: str, load: Callable[[], LoadedRack], *, effects: bool) -> Answer:
        """Load an edited program with `load`; return a function that creates its preview or its mistakes."""
        program = self._programs.file
        show_preview = partial(preview_of, program, (self._programs.running_text, text))
        try:
            job = self._programs.usable(load(), restart)
            running, running_findings = self._programs.reloaded()
            findings = new_findings(findings_of(job), running_findings)
            changes = effects_between(running, job) if effects else ()
        except (ValueError, OSError) as error:
            refusals = mistakes_of(error, program)
            return lambda: {"preview": show_preview(mistakes=refusals)}

        def answer() -> Json:
            try:
                edit = self._run.program.planned(self._run.cpu, job, names_in(restart))
            except ValueError as error:
                return {"preview": show_preview(mistakes=mistakes_of(error, program))}
            return {"preview": show_preview(edit=edit, findings=findings, effects=changes)}

        return answer


def effects_between(running: LoadedRack, edited: LoadedRack) -> tuple[Group, ...]:
    """Return the possible effects of editing rungs; empty for other programs."""
    if not isinstance(running.logic, LadderLogic) or not isinstance(edited.logic, LadderLogic):
        return ()
    return effects_of(running.logic, edited.logic)
