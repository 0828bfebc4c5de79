"""Answers to questions about edited rungs: their mistakes, their drawing, and their effects on past scans.

The page has the draft, and sends it with each question. The monitor checks it against the running program.
The scan process accepts it.
"""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.ladder.lowering.edited import CheckedRung, EditedProgram, Mistake, NewTag, RungEdit, types_of
from scanrack.ladder.lowering.rebase import moved
from scanrack.ladder.model.spec import Use
from scanrack.runtime.live.actions import Online, action_of

from ..history.catalog import Catalog
from ..history.program_file import declares_tags, read_edit, why_not_editable
from ..history.stretch import Stretch
from .fields import Question, columns_in
from .monitor import Json, Monitor
from .page import Page
from .question_process import effects
from .stretched import ReplayPackage

LOOKED_BACK_NS = 10_000_000_000
"""Length of time before the latest scan over which an edit is tried, ns."""

MOST_SCANS = 20_000
"""Maximum number of scans in this time, since a rack may run faster than real time."""


def words(monitor: Monitor, _page: Page, _question: Question) -> Json:
    """Return the instructions and types that rungs may use, and a digest of the program."""
    program, _catalog = _edited(monitor)
    logic, _ = program.ladder, program.rung_index  # create the index before the first edit needs it
    instructions = [
        {
            "name": spec.name,
            "operands": list(map(str, spec.captions)) or [use.name.lower() for use in spec.uses],
            "presets": spec.operands.count(Use.PRESET),
            "bits": bool(spec.symbol),
        }
        for spec in dict.fromkeys(logic.specs.values())
        if spec.in_rungs
    ]
    return {"base": program.digest, "instructions": instructions, "types": sorted(types_of(logic))}


def rungs(monitor: Monitor, _page: Page, question: Question) -> Json:
    """Check edited rungs and draw them.

    The answer has the rungs with their mistakes, undeclared tags, and whether the draft can be accepted.
    """
    program, catalog = _edited(monitor)
    columns = columns_in(question)
    draft = _draft(program, question, ("columns",))
    assert program.file is not None
    edits = [read_edit(program.file.name, rung, program.ladder.specs) for rung in draft.rungs]
    tags = [NewTag(*tag) for tag in draft.tags]
    edited_program = EditedProgram(program.ladder, edits, tags, program.rung_index)
    drawn = [_drawn(catalog, rung, columns) for rung in edited_program.rungs]
    declared = edited_program.missing if declares_tags(program.file) else []
    missing = [{"name": tag.name, "program": tag.program, "types": tag.types} for tag in declared]
    return {
        "rungs": drawn,
        "missing": missing,
        "mistakes": edited_program.mistakes,
        "right": edited_program.is_right,
    }


def _drawn(catalog: Catalog, checked: CheckedRung, columns: int) -> Json:
    """Return an edited rung for a page: its mistakes, and its drawing if it is a rung."""
    edit = checked.edit
    fields = {
        "routine": edit.routine,
        "rung": edit.rung,
        "text": checked.text,
        "mistakes": [_row_of(mistake) for mistake in checked.mistakes],
        "warnings": [_row_of(warning) for warning in checked.warnings],
    }
    if checked.rung is None:
        return fields
    drawn = catalog.draw(checked.rung, edit.routine, f"{edit.routine}.{edit.rung}e{checked.number}", columns)
    return {**fields, "svg": drawn.svg, "gaps": drawn.gaps}


def _row_of(mistake: Mistake) -> Json:
    return {"text": mistake.text, "element": mistake.element, "column": mistake.column}


def rebase(monitor: Monitor, _page: Page, question: Question) -> Json:
    """Return a draft that was based on an earlier program, adapted to the running program."""
    program, _catalog = _edited(monitor)
    draft = _parsed(question)
    programs = {earlier.digest: earlier for earlier in reversed(monitor.subject.programs.all)}
    base_program = programs.get(draft.base)
    if base_program is None or base_program.catalog is None:
        raise ValueError("the program on which the draft is based is no longer known")
    rebased = moved(base_program.ladder, program.ladder, [RungEdit(*rung) for rung in draft.rungs])
    declared = program.ladder.build().layout.declarations
    tags = [tag for tag in draft.tags if NewTag(*tag).full_name.upper() not in declared]
    moved_rungs = [(edit.routine, edit.rung, edit.texts) for edit in rebased.edits]
    return {"base": program.digest, "rungs": moved_rungs, "tags": tags, "conflicts": rebased.conflicts}


def would(monitor: Monitor, page: Page, question: Question) -> None:
    """Start a process that finds what edited rungs would have changed in the last 10 s."""
    program, _catalog = _edited(monitor)
    draft, row = _draft(program, question), monitor.latest
    ran = monitor.ran
    if row is None or ran is None:
        raise ValueError("no scan has run yet")
    last = int(row["scan"])
    first_requested = last - min(LOOKED_BACK_NS // monitor.subject.spec.scan_ns, MOST_SCANS)
    start = program.store.index_for(max(first_requested, program.first))
    if start is None:
        start = 0  # the first snapshot, if there is one
    if start >= len(program.store.scans) or program.store.scans[start] > last:
        raise ValueError("the values of the latest scans are not known yet")
    first = program.store.scans[start]
    rows = monitor.subject.timeline.between(first, last)
    inputs = [scan_inputs for scan, scan_inputs in program.store.inputs.items() if first <= scan <= last]
    package = ReplayPackage(
        first=first,
        values=program.store.values(start),
        forces=program.store.forces(first),
        inputs=inputs,
        rows=rows,
        layout=monitor.subject.spec.layout,
        ran=ran,
        rungs=draft.rungs,
        tags=draft.tags,
    )
    monitor.processes.start(page, question.get("id"), effects(package))


def _draft(program: Stretch, question: Question, more: Sequence[str] = ()) -> Online:
    """Return the draft in a question; raise ValueError if it is not based on the running program."""
    draft = _parsed(question, more)
    if draft.base != program.digest:
        raise ValueError("the program has changed meanwhile; edit the one that runs now")
    return draft


def _parsed(question: Question, more: Sequence[str] = ()) -> Online:
    """Return the draft in a question; `more` are other keys that the question can have."""
    fields = {key: value for key, value in question.items() if key not in ("id", "do", *more)}
    draft = action_of({"do": "online", "step": "accept", **fields}, {"online": Online})
    assert isinstance(draft, Online)
    return draft


def _edited(monitor: Monitor) -> tuple[Stretch, Catalog]:
    """Return the running program; raise ValueError if pages can't edit its rungs."""
    program = monitor.subject.programs.latest
    if monitor.about.read_only or monitor.about.kind != "rack":
        raise ValueError("this session is read-only: nothing is edited")
    if program.catalog is None or program.file is None:
        raise ValueError("the program has no rungs")
    if obstacle := why_not_editable(program.file):
        raise ValueError(obstacle)
    return program, program.catalog
