"""Facts of a ladder program: its writes to the 3601s, its tags and terminals, its conditions and routines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.cards import KINDS
from scanrack.io_images.drives.translation import model_of
from scanrack.io_images.site import Site
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import cross_reference
from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.model.chart_checks import unreached
from scanrack.ladder.model.operands import Place
from scanrack.ladder.model.tags import tag_in
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram, LoweredStep, steps_of
from scanrack.runtime.config.rackspec import RackSpec, profile_in

from ...load.program import EXPORT_SUFFIXES, SLC_SUFFIXES
from ..facts import Facts, FileLine, LocalFinding, SentCommand
from .accesses import Variables, accesses_of, declaration_lines
from .add_ons import note_add_ons
from .block_mistakes import called_twice, misordered, parameters_out_of_range
from .blocks import block_calls, commands_of, slots_of
from .calls import RoutineCalls, exclusive_repeats
from .conditions import Conditions, on_delays
from .controls import shared
from .counting import never_run, unbounded
from .drive_axes import fastest, note_drives
from .loops import counted, counts_by_site, endless
from .mistakes import Mistakes, sealed
from .number_ranges import Values
from .output_writes import WriteReader, path_of
from .outputs import OutputBits
from .reals import note_reals
from .sent_words import SentWords
from .steps import Steps
from .structure import Structure, own_add_ons, own_routines
from .subscripts import note_lengths, note_subscripts
from .terminals import Terminals
from .timing import note_timing
from .walk import Walker
from .word_writes import word_writes
from .written_words import computed, held, words_out_of_range


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Read the facts of a ladder program; LadderError if it can't be built.

    Args:
        path: its file, for messages.
    """
    return _ProgramReader(program, path, spec).facts()


class _ProgramReader:
    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        self.program, self.path, self.spec = program, path, spec
        self.lowered: LoweredProgram = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.declared = declaration_lines(path)
        self.slots = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        drives = {slot.number: model_of(slot.words) for slot in spec.slot}
        self.drives = {number: model for number, model in drives.items() if model is not None}
        self.tags = self.lowered.layout.tags()
        every = [step for routine in self.lowered.routines.values() for line in routine.lines
                 for step in steps_of(line.nodes)]  # fmt: skip
        loops = counted(self.lowered.routines.values())
        self.values = Values(every, self.mentions, self.tags, self.lowered.presets, loops)
        self.counts = counts_by_site(self.lowered.routines.values())
        self.writes = WriteReader(
            self.lowered, self.mentions, self.slots, self.values, self.counts, self._place
        )
        self.conditions = Conditions(self.values, on_delays(every))
        walker = Walker(self.conditions)
        self.routines = own_routines(program, self.lowered)
        self.points = [(each, self._place(each.line)) for own in self.routines for each in walker.points(own)]
        self.main = [each for each in self.points if not each[0].routine.frame]
        self.lines = [
            (routine.body is None, line)
            for routine in self.lowered.routines.values()
            if not routine.frame
            for line in routine.lines
        ]
        self.calls = list(block_calls(self.main))
        self.axes = slots_of(self.calls)
        self.owners = self._owners()
        self.stubbed = {str(getattr(each, "to", "")).upper() for each in spec.stubs.values()}

    def facts(self) -> Facts:
        facts = Facts(reads_all=bool(self.lowered.functions))
        calls = RoutineCalls(self.main)
        for rule, remark in self._warnings(calls):
            facts.remark(rule, *remark)
        facts.remarks["unreached-step"] += self._unreached()
        self._sites(facts)
        self._commands(facts)
        self._tags(facts)
        self._text(facts)
        misordered(self.calls, self.axes, facts, has_other_axes=bool(self.lowered.axes))
        called_twice(self.main, facts)
        shared(self.main, self.mentions, facts)
        calls.twice(facts)
        endless(self.routines, self._place, facts)
        return facts

    def _warnings(self, calls: RoutineCalls) -> Iterator[tuple[str, LocalFinding]]:
        """Yield the warnings of the build, without coils of routines that exclude each other."""
        repeated = []
        for each in self.program.warnings:
            remark = LocalFinding(FileLine(each.site.file or str(self.path), each.site.line or 1), each.text)
            if each.rule == "repeated-coil":
                repeated.append(remark)
            else:
                yield each.rule or "repeated-coil", remark
        mixed = calls.mixed(self._written, latches=self.path.suffix in EXPORT_SUFFIXES)
        for remark in (*exclusive_repeats(repeated, self.main, calls), *mixed):
            yield "repeated-coil", remark

    def _commands(self, facts: Facts) -> None:
        """Note what the program sends to the 3601s."""
        writes = [each for rungs, line in self.lines for each in self.writes.writes(rungs, line)]
        lines = [(line, self._place(line)) for _, line in self.lines]
        sent = SentWords(self.writes, lines, writes, self.slots, self.axes, self.drives)
        homes = (each for each in self.calls if each.call.name == "MC_HOME")
        facts.configurations = list(sent.configurations())
        facts.searches = [
            *sent.searches(),
            *(SentCommand(each.place, self.axes.get(each.axis)) for each in homes),
        ]
        facts.remarks["command-held"] += held(writes)
        limits = fastest(profile_in(self.slots.values(), None).limits, self.drives.values())
        wrong = [*sent.out_of_range(), *parameters_out_of_range(self.main, self.values, self.tags, limits)]
        reported = {each.place for each in wrong}
        wrong += [each for each in words_out_of_range(writes, self.slots) if each.place not in reported]
        facts.remarks["out-of-range"] += wrong
        facts.remarks["out-of-range"] += note_drives(
            self.calls, self.axes, self.drives, self.writes.constants_at
        )
        facts.not_seen += computed(writes)
        unknown = {each.slot for each in writes if not each.known and each.word < 2}
        facts.computed = unknown | self.writes.staged
        facts.at_once = list(sent.at_once())
        blocks = list(commands_of(self.calls, self.axes, self.values, self.owners))
        steps = Steps(self.main, self.values, self.conditions.places, self.slots)
        executed = [(each, *steps.executed(each)) for each in blocks]
        blocks = [
            replace(each, starts=steps.starts(each), on=on, implies=implies) for each, on, implies in executed
        ]
        facts.commands = [*blocks, *sent.commands()]
        facts.actions = list(steps.actions(writes, blocks))
        facts.step_use, facts.first_steps = steps.use, steps.first
        facts.writes = list(word_writes(self.main, writes, steps, self.lowered))
        facts.outputs = list(OutputBits(self.main, self.conditions.places, self.slots).writes())

    def _sites(self, facts: Facts) -> None:
        for routine in self.routines:
            for line in routine.lines:
                place = self._place(line)
                site = Site(
                    self.lowered.name,
                    routine.name,
                    line.number,
                    unit=routine.unit,
                    file=place.file,
                    line=place.line,
                )
                facts.sites.setdefault(place, site)

    def _unreached(self) -> Iterator[LocalFinding]:
        for routine in self.program.routines:
            origins = {each.number: each.origin for each in routine.chart.steps} if routine.chart else {}
            for each in unreached(routine.chart) if routine.chart else ():
                origin = origins[each.number]
                text = f"{each.text}, in chart {routine.name}; only SFR can reach it"
                yield LocalFinding(FileLine(origin.file or str(self.path), origin.line or 1), text)

    # --- the text

    def _owners(self) -> dict[str, str]:
        """Return the task of each program, in capitals; none if there is one task."""
        schedule = self.lowered.schedule
        tasks = [each for each in schedule.tasks if each.programs] if schedule is not None else []
        if len(tasks) < 2:
            return {}
        return {program.name.upper(): each.task.name for each in tasks for program in each.programs}

    def _text(self, facts: Facts) -> None:
        """Note accesses, and the mistakes of instructions and routines."""
        outside = frozenset(
            path_of(each.where).partition(".")[2]
            for point, _ in self.main
            for each in mentions_of(self.lowered.sites[point.step.site], point.step)
            if each.writes
        )
        variables = Variables(self.lowered, self.path, self._is_recorded, outside)
        facts.variables = variables.found
        for point, place in self.points:
            facts.accesses += accesses_of(point, self.lowered, variables, place, self.owners)
        read = frozenset(
            path_of(each.where) for each in self.mentions if each.reads and isinstance(each.where, Place)
        )
        mistakes = Mistakes(
            *(self.lowered, self.values, facts, read),
            made=self.path.suffix == ".py",
            scan_ms=float(self.spec.scan_ms),
        )
        seen: set[tuple[str, str]] = set()
        for point, place in self.points:
            mistakes.note(point, place)
            note_subscripts(point, place, self.counts, facts, seen)
            note_lengths(point, place, facts)
        add_ons = own_add_ons(self.program)
        note_add_ons(add_ons, self.points, self.lowered, outside, self._declaration, facts)
        analog = [slot.number for slot in self.spec.slot if _is_analog(slot.module)]
        note_reals(self.points, self.values, analog, facts, self._written)
        note_timing(self.points, self.mentions, self.values, self.tags, facts, self._written)
        sealed(self.main, self.conditions.places, facts, self._written)
        unbounded(self.points, self.values, self.conditions.places, facts)
        if self.path.suffix != ".py" and not facts.reads_all:
            never_run(facts)
        for routine in self.routines:
            for line in routine.lines if routine.body is None else ():
                mistakes.branches(line, self.conditions, self._place(line))
        Structure(self.program, self.lowered, facts, str(self.path), self.declared).note(self.routines)

    def _is_recorded(self, tag: str) -> bool:
        if tag.upper() in self.stubbed:
            return True
        return any(
            fnmatch(f"{tag}.".upper(), f"{pattern.upper().partition('.')[0]}.") for pattern in self.spec.tags
        )

    # --- tags and terminals

    def _tags(self, facts: Facts) -> None:
        terminals = Terminals(self.lowered, self.mentions, self.spec, self.path, self.declared)
        lines = [(line, self._place(line)) for _, line in self.lines]
        facts.remarks["no-place"] += terminals.misplaced(lines, self.calls)
        if self.lowered.functions:
            names = ", ".join(self.lowered.functions)
            facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
            return
        facts.uses_bit = terminals.uses_bit()
        used = {tag_in(path_of(each.where, as_written=True)).upper() for each in self.mentions}
        if self.path.suffix in SLC_SUFFIXES:
            return  # its data files are there, used or not
        for name, tag in self.tags.items():
            recorded = any(fnmatch(name, pattern.upper()) for pattern in self.spec.tags)
            if name not in used and not recorded:
                place = FileLine(str(self.path), self.declared(tag.name))
                facts.remark("unused-tag", place, f"tag {tag.name} is declared, and no instruction names it")

    def _declaration(self, name: str) -> FileLine:
        return FileLine(str(self.path), self.declared(name))

    def _written(self, step: LoweredStep) -> str:
        return self.lowered.sites[step.site].instruction

    def _place(self, line: LoweredLine) -> FileLine:
        return FileLine(line.origin.file or str(self.path), line.origin.line or 1)


def _is_analog(module: str) -> bool:
    return module in KINDS and KINDS[module].channels_in > 0
