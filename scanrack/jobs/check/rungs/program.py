"""Facts of a ladder program: writes to the 3601s, tags and terminals, conditions and routines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path

from scanrack.io_images.site import Site
from scanrack.ladder import LadderLogic
from scanrack.ladder.instructions.slc.status import STATUS
from scanrack.ladder.lowering.dialects import SLC
from scanrack.ladder.model.chart_checks import unreached
from scanrack.ladder.model.tags import tag_in
from scanrack.runtime.config.rackspec import RackSpec, profile_in

from ...load.program import EXPORT_SUFFIXES, SLC_SUFFIXES
from ..facts import Facts, SentCommand, Violation
from ..written import place_at
from .accesses import Variables, accesses_of
from .add_ons import note_add_ons
from .block_mistakes import called_twice, misordered, parameters_out_of_range, slots_shared
from .blocks import commands_of
from .calls import RoutineCalls, exclusive_repeats
from .controls import shared
from .counting import never_run, unbounded
from .drive_axes import fastest, note_drives
from .loops import endless
from .mistakes import Mistakes, sealed
from .operands import path_of
from .output_writes import Write, WriteReader
from .outputs import OutputBits
from .reals import note_reals
from .sent_words import SentWords
from .steps import Steps
from .structure import Structure
from .terminals import Terminals
from .timing import note_timing
from .view import LadderView
from .written_words import computed, never_cleared, words_out_of_range


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Return the facts of a ladder program; raise LadderError if it can't be built.

    Args:
        path: file of the program, for messages.
    """
    view = LadderView(program, path, spec)
    facts = Facts(reads_all=bool(view.lowered.functions))
    calls = RoutineCalls(view.main)
    for rule, remark in _warnings(view, calls):
        facts.remark(rule, *remark)
    facts.remarks["unreached-step"] += _unreached(view)
    _note_sites(view, facts)
    _note_commands(view, calls, facts)
    _note_tags(view, facts)
    _note_text(view, facts)
    slots_shared(view, facts)
    misordered(view, facts)
    called_twice(view.main, facts)
    shared(view, facts)
    calls.note_repeats(facts)
    endless(view.routines, view.place, facts)
    return facts


def _warnings(view: LadderView, calls: RoutineCalls) -> Iterator[tuple[str, Violation]]:
    """Yield the warnings of the build, except those about coils in routines that exclude each other."""
    repeated = []
    for warning in view.program.warnings:
        remark = Violation(place_at(warning.site, view.path), warning.text)
        if warning.rule == "repeated-coil":
            repeated.append(remark)
        else:
            yield warning.rule or "repeated-coil", remark
    mixed = calls.mixed(latches=view.path.suffix in EXPORT_SUFFIXES)
    for remark in (*exclusive_repeats(repeated, view.main, calls), *mixed):
        yield "repeated-coil", remark


def _unreached(view: LadderView) -> Iterator[Violation]:
    """Yield the steps of charts that no path reaches."""
    for routine in view.program.routines:
        if routine.chart:
            origins = {step.number: step.origin for step in routine.chart.steps}
            for step in unreached(routine.chart):
                text = f"{step.text}, in chart {routine.name}; only SFR can reach it"
                yield Violation(place_at(origins[step.number], view.path), text)


def _note_sites(view: LadderView, facts: Facts) -> None:
    """Note the routine and rung of each line."""
    for routine in view.routines:
        for line in routine.lines:
            place, unit = view.place(line), routine.unit
            site = Site(view.lowered.name, routine.name, line.number, "", unit, place.file, place.line)
            facts.sites.setdefault(place, site)


def _note_commands(view: LadderView, calls: RoutineCalls, facts: Facts) -> None:
    """Note the commands that the program sends to the 3601s."""
    reader = WriteReader(view)
    writes = list(reader.writes())
    sent_words = SentWords(view, reader, writes)
    homes = [call for call in view.calls if call.call.name == "MC_HOME"]
    facts.configurations = list(sent_words.configurations())
    facts.searches = [
        *sent_words.searches(),
        *(SentCommand(home.place, view.axes.get(home.axis)) for home in homes),
    ]
    facts.remarks["command-held"] += never_cleared(writes)
    facts.remarks["out-of-range"] += _out_of_range(view, reader, sent_words, writes)
    facts.not_seen += computed(writes)
    facts.computed = {write.slot for write in writes if not write.known and write.word < 2}
    facts.computed |= reader.staged
    facts.at_once = list(sent_words.at_once())
    steps = Steps(view, calls)
    blocks = list(map(steps.with_start, commands_of(view.calls, view.axes, view.values, view.owners)))
    facts.commands = [*blocks, *sent_words.commands()]
    facts.actions = list(steps.actions(writes, blocks))
    facts.step_use, facts.first_steps = steps.use, steps.first
    facts.writes = list(steps.word_writes(writes))
    facts.outputs = list(OutputBits(view).writes())


def _out_of_range(
    view: LadderView, reader: WriteReader, sent: SentWords, writes: Sequence[Write]
) -> Iterator[Violation]:
    """Yield values that modules and drives refuse; single words only at lines without another finding."""
    limits = fastest(profile_in(view.steppers.values(), None).limits, view.drives.values())
    violations = [*sent.out_of_range(), *parameters_out_of_range(view, limits)]
    yield from violations
    reported = {violation.place for violation in violations}
    for violation in words_out_of_range(writes, view.steppers):
        if violation.place not in reported:
            yield violation
    yield from note_drives(view, reader.constants_at)


def _note_tags(view: LadderView, facts: Facts) -> None:
    """Note terminals that the rack lacks, the use of terminals, and unused tags."""
    terminals = Terminals(view)
    facts.remarks["no-place"] += terminals.misplaced()
    if view.lowered.functions:
        names = ", ".join(view.lowered.functions)
        facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
        return
    facts.uses_bit = terminals.uses_bit()
    if view.path.suffix not in SLC_SUFFIXES:  # the data files of an SLC exist even if unused
        _note_unused(view, facts)


def _note_unused(view: LadderView, facts: Facts) -> None:
    """Note tags that no instruction uses and that are not recorded."""
    tags_used = {tag_in(path_of(mention.where)) for mention in view.mentions}
    if view.program.dialect == SLC:
        tags_used.add(STATUS)  # instructions use the processor's status file without naming it
    for name, tag in view.tags.items():
        recorded = any(fnmatch(name, pattern.upper()) for pattern in view.spec.tags)
        if name not in tags_used and not recorded:
            text = f"tag {tag.name} is declared, but no instruction uses it"
            facts.remark("unused-tag", view.declaration(tag.name), text)


def _note_text(view: LadderView, facts: Facts) -> None:
    """Note accesses, and mistakes in instructions and routines."""
    variables = Variables(view)
    facts.variables = variables.by_key
    for point in view.points:
        facts.accesses += accesses_of(point, view, variables)
    Mistakes(view, facts).note()
    note_add_ons(view, facts)
    note_reals(view, facts)
    note_timing(view, facts)
    sealed(view, facts)
    unbounded(view, facts)
    if view.path.suffix != ".py" and not facts.reads_all:
        never_run(facts)
    Structure(view, facts).note()
