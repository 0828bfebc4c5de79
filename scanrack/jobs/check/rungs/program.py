"""Facts of a ladder program: writes to the 3601s, tags and terminals, conditions and routines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from functools import cached_property
from itertools import chain
from pathlib import Path

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.cards import KINDS
from scanrack.io_images.drives.models import Model
from scanrack.io_images.drives.translation import model_of
from scanrack.io_images.site import Site
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import cross_reference
from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.model.chart_checks import unreached
from scanrack.ladder.model.tags import tag_in
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram
from scanrack.runtime.config.rackspec import RackSpec, profile_in

from ...load.program import EXPORT_SUFFIXES, SLC_SUFFIXES
from ..facts import Facts, FileLine, SentCommand, Violation
from ..written import place_at
from .accesses import Variables, accesses_of, declaration_lines
from .add_ons import note_add_ons
from .block_mistakes import called_twice, misordered, parameters_out_of_range, slots_shared
from .blocks import block_calls, commands_of, slots_of
from .calls import RoutineCalls, exclusive_repeats
from .conditions import Conditions, on_delays
from .controls import shared
from .counting import never_run, unbounded
from .drive_axes import fastest, note_drives
from .loops import counted, counts_by_site, endless
from .mistakes import Mistakes, sealed
from .number_ranges import Values
from .operands import path_of, steps_in
from .output_writes import Write, WriteReader
from .outputs import OutputBits
from .reals import note_reals
from .sent_words import SentWords
from .steps import Steps
from .structure import Structure, own_add_ons, own_routines
from .subscripts import note_lengths, note_subscripts
from .terminals import Terminals
from .timing import note_timing
from .walk import Walker
from .written_words import computed, held, words_out_of_range


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Return the facts of a ladder program; LadderError if it can't be built.

    Args:
        path: file of the program, for messages.
    """
    return _ProgramReader(program, path, spec).facts()


class _ProgramReader:
    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        self.program, self.path, self.spec = program, path, spec
        self.lowered: LoweredProgram = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.declared = declaration_lines(path)
        self.slots = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        self.drives = dict(_drives_of(spec))
        self.tags = self.lowered.layout.tags()
        routines = self.lowered.routines.values()
        every = list(steps_in(*routines))
        self.values = Values(every, self.mentions, self.tags, self.lowered.presets, counted(routines))
        self.counts = counts_by_site(routines)
        self.writes = WriteReader(
            self.lowered, self.mentions, self.slots, self.values, self.counts, self._place
        )
        self.conditions = Conditions(self.values, on_delays(every))
        walker = Walker(self.conditions, self.lowered, path)
        self.routines = own_routines(program, self.lowered)
        self.points = list(chain.from_iterable(map(walker.points, self.routines)))
        self.main = [point for point in self.points if not point.routine.frame]
        own = [routine for routine in routines if not routine.frame]
        self.lines = [(routine.body is None, line) for routine in own for line in routine.lines]
        self.calls = list(block_calls(self.main))
        self.axes = slots_of(self.calls)
        self.owners = self._owners()
        self.stubbed = {str(getattr(each, "to", "")).upper() for each in spec.stubs.values()}

    @cached_property
    def read(self) -> frozenset[str]:
        """Paths that the program reads, in capitals, such as COUNT.DN."""
        return frozenset(path_of(each.where) for each in self.mentions if each.reads)

    def facts(self) -> Facts:
        facts = Facts(reads_all=bool(self.lowered.functions))
        calls = RoutineCalls(self.main)
        for rule, remark in self._warnings(calls):
            facts.remark(rule, *remark)
        facts.remarks["unreached-step"] += self._unreached()
        self._sites(facts)
        self._commands(calls, facts)
        self._tags(facts)
        self._text(facts)
        slots_shared(self.calls, self.axes, facts)
        misordered(self.calls, facts, has_other_axes=bool(self.lowered.axes))
        called_twice(self.main, facts)
        shared(self.main, self.mentions, self.read, facts)
        calls.twice(facts)
        endless(self.routines, self._place, facts)
        return facts

    def _warnings(self, calls: RoutineCalls) -> Iterator[tuple[str, Violation]]:
        """Yield the warnings of the build, except about coils in routines that exclude each other."""
        repeated = []
        for each in self.program.warnings:
            remark = Violation(place_at(each.site, self.path), each.text)
            if each.rule == "repeated-coil":
                repeated.append(remark)
            else:
                yield each.rule or "repeated-coil", remark
        mixed = calls.mixed(latches=self.path.suffix in EXPORT_SUFFIXES)
        for remark in (*exclusive_repeats(repeated, self.main, calls), *mixed):
            yield "repeated-coil", remark

    def _commands(self, calls: RoutineCalls, facts: Facts) -> None:
        """Note the commands that the program sends to the 3601s."""
        writes = [each for rungs, line in self.lines for each in self.writes.writes(rungs, line)]
        lines = [(line, self._place(line)) for _, line in self.lines]
        sent = SentWords(self.writes, lines, writes, self.slots, self.axes, self.drives)
        homes = [each for each in self.calls if each.call.name == "MC_HOME"]
        facts.configurations = list(sent.configurations())
        facts.searches = [*sent.searches(), *(SentCommand(e.place, self.axes.get(e.axis)) for e in homes)]
        facts.remarks["command-held"] += held(writes)
        facts.remarks["out-of-range"] += self._out_of_range(sent, writes)
        facts.not_seen += computed(writes)
        facts.computed = {each.slot for each in writes if not each.known and each.word < 2}
        facts.computed |= self.writes.staged
        facts.at_once = list(sent.at_once())
        steps = Steps(self.main, calls, self.values, self.conditions.places, self.slots)
        blocks = list(map(steps.with_start, commands_of(self.calls, self.axes, self.values, self.owners)))
        facts.commands = [*blocks, *sent.commands()]
        facts.actions = list(steps.actions(writes, blocks))
        facts.step_use, facts.first_steps = steps.use, steps.first
        facts.writes = list(steps.word_writes(writes))
        facts.outputs = list(OutputBits(self.main, self.conditions.places, self.slots).writes())

    def _out_of_range(self, sent: SentWords, writes: Sequence[Write]) -> Iterator[Violation]:
        """Yield values that modules and drives refuse; of single words, only what no copy has reported."""
        limits = fastest(profile_in(self.slots.values(), None).limits, self.drives.values())
        wrong = [*sent.out_of_range(), *parameters_out_of_range(self.main, self.values, self.tags, limits)]
        yield from wrong
        reported = {each.place for each in wrong}
        yield from (each for each in words_out_of_range(writes, self.slots) if each.place not in reported)
        yield from note_drives(self.calls, self.axes, self.drives, self.writes.constants_at)

    def _sites(self, facts: Facts) -> None:
        for routine in self.routines:
            for line in routine.lines:
                place, unit = self._place(line), routine.unit
                site = Site(self.lowered.name, routine.name, line.number, "", unit, place.file, place.line)
                facts.sites.setdefault(place, site)

    def _unreached(self) -> Iterator[Violation]:
        for routine in self.program.routines:
            origins = {each.number: each.origin for each in routine.chart.steps} if routine.chart else {}
            for each in unreached(routine.chart) if routine.chart else ():
                text = f"{each.text}, in chart {routine.name}; only SFR can reach it"
                yield Violation(place_at(origins[each.number], self.path), text)

    # --- the text

    def _owners(self) -> dict[str, str]:
        """Return the task of each program, in capitals; empty if there is only one task."""
        schedule = self.lowered.schedule
        tasks = [each for each in schedule.tasks if each.programs] if schedule is not None else []
        if len(tasks) < 2:
            return {}
        return {program.name.upper(): each.task.name for each in tasks for program in each.programs}

    def _text(self, facts: Facts) -> None:
        """Note accesses, and mistakes in instructions and routines."""
        outside = frozenset(self._written_members())
        variables = Variables(self.lowered, self.path, self._is_recorded, outside, self._declaration)
        facts.variables = variables.found
        for point in self.points:
            facts.accesses += accesses_of(point, self.lowered, variables, self.owners)
        self._mistakes(facts)
        note_add_ons(own_add_ons(self.program), self.points, self.lowered, outside, self._declaration, facts)
        analog = [slot.number for slot in self.spec.slot if _is_analog(slot.module)]
        note_reals(self.points, self.values, analog, facts)
        note_timing(self.points, self.mentions, self.values, self.tags, facts)
        sealed(self.main, self.conditions.places, facts)
        unbounded(self.points, self.values, self.conditions.places, facts)
        if self.path.suffix != ".py" and not facts.reads_all:
            never_run(facts)
        Structure(self.program, self.lowered, facts, self._place, self._declaration).note(self.routines)

    def _written_members(self) -> Iterator[str]:
        """Yield the instance members that the calling program itself writes, in capitals."""
        for point in self.main:
            for each in mentions_of(self.lowered.sites[point.step.site], point.step):
                if each.writes:
                    yield path_of(each.where).partition(".")[2]

    def _mistakes(self, facts: Facts) -> None:
        """Note the mistakes within one rung or statement."""
        mistakes = Mistakes(
            *(self.lowered, self.values, facts, self.read),
            made=self.path.suffix == ".py",
            scan_ms=float(self.spec.scan_ms),
        )
        seen: set[tuple[str, str]] = set()
        for point in self.points:
            mistakes.note(point)
            note_subscripts(point, self.counts, facts, seen)
            note_lengths(point, facts)
        for routine in self.routines:
            for line in routine.lines if routine.body is None else ():
                mistakes.branches(line, self.conditions, self._place(line))

    def _is_recorded(self, tag: str) -> bool:
        if tag.upper() in self.stubbed:
            return True
        patterns = (pattern.upper().partition(".")[0] for pattern in self.spec.tags)
        return any(fnmatch(f"{tag}.".upper(), f"{pattern}.") for pattern in patterns)

    # --- tags and terminals

    def _tags(self, facts: Facts) -> None:
        terminals = Terminals(self.lowered, self.mentions, self.spec, self.path, self._declaration)
        lines = [(line, self._place(line)) for _, line in self.lines]
        facts.remarks["no-place"] += terminals.misplaced(lines, self.calls)
        if self.lowered.functions:
            names = ", ".join(self.lowered.functions)
            facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
            return
        facts.uses_bit = terminals.uses_bit()
        if self.path.suffix not in SLC_SUFFIXES:  # the data files of an SLC exist even if unused
            self._unused(facts)

    def _unused(self, facts: Facts) -> None:
        """Note tags that no instruction names and that are not recorded."""
        used = {tag_in(path_of(each.where, as_written=True)).upper() for each in self.mentions}
        for name, tag in self.tags.items():
            recorded = any(fnmatch(name, pattern.upper()) for pattern in self.spec.tags)
            if name not in used and not recorded:
                text = f"tag {tag.name} is declared, and no instruction names it"
                facts.remark("unused-tag", self._declaration(tag.name), text)

    def _declaration(self, name: str) -> FileLine:
        return FileLine(str(self.path), self.declared(name))

    def _place(self, line: LoweredLine) -> FileLine:
        return place_at(line.origin, self.path)


def _drives_of(spec: RackSpec) -> Iterator[tuple[int, Model]]:
    """Yield the networked drives of a rack, each with its slot."""
    for slot in spec.slot:
        model = model_of(slot.words)
        if model is not None:
            yield slot.number, model


def _is_analog(module: str) -> bool:
    return module in KINDS and KINDS[module].channels_in > 0
