"""A ladder program as the collectors read it: its instructions, ranges of numbers, and blocks."""

from __future__ import annotations

from fnmatch import fnmatch
from functools import cached_property
from itertools import chain
from pathlib import Path

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.drives.translation import model_of
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import cross_reference
from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.files.rungreader import is_of_library
from scanrack.ladder.lowering.addon import AddOn
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram, LoweredRoutine
from scanrack.runtime.config.rackspec import RackSpec

from ..facts import FileLine
from ..written import declaration_lines, place_at
from .blocks import block_calls, slots_of
from .conditions import Conditions, on_delays
from .loops import counted, counts_by_site
from .number_ranges import Values
from .operands import path_of, steps_in
from .walk import Walker

LIBRARY = "axis3601"
"""The library of motion blocks, which are not the user's code."""


def own_add_ons(program: LadderLogic) -> list[AddOn]:
    """Return the program's own add-on instructions, without the library of motion blocks."""
    return [add_on for add_on in program.add_ons.values() if not is_of_library(add_on, LIBRARY)]


def own_routines(program: LadderLogic, lowered: LoweredProgram) -> list[LoweredRoutine]:
    """Return the routines that the user has written."""
    frames = {"", *(add_on.name.upper() for add_on in own_add_ons(program))}
    return [routine for routine in lowered.routines.values() if routine.frame in frames]


class LadderView:
    """A ladder program, and facts that several collectors need.

    Attributes:
        path: file of the program, for messages.
        mentions: all operands of the program.
        tags: tags by name in capitals.
        steppers: slots of 3601s.
        drives: networked drives by slot.
        values: ranges of the program's numbers.
        counts: for each instruction in the body of a FOR, the ranges of the counts, by path in capitals.
        places: operands by key.
        routines: the routines that the user has written.
        points: the instructions of these routines.
        main: the instructions of `points` outside add-on instructions.
        own: all routines outside add-on instructions.
        lines: the lines of the routines in `own`, each with its place.
        calls: calls of motion blocks.
        axes: slots of the axes of motion blocks.
        owners: the task of each program, in capitals; empty if there is only one task.
    """

    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        """Build the program, and collect its facts. Later attributes need the earlier ones."""
        self.program, self.path, self.spec = program, path, spec
        self.lowered = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.tags = self.lowered.layout.tags()
        self.steppers = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        drives = ((slot.number, model_of(slot.words)) for slot in spec.slot)
        self.drives = {number: model for number, model in drives if model is not None}
        self._declaration_line = declaration_lines(path)
        routines = self.lowered.routines.values()
        steps = list(steps_in(*routines))
        self.values = Values(steps, self.mentions, self.tags, self.lowered.presets, counted(routines))
        self.counts = counts_by_site(routines)
        self.conditions = Conditions(self.values, on_delays(steps))
        self.places = self.conditions.places
        self.add_ons = own_add_ons(program)
        self.routines = own_routines(program, self.lowered)
        walker = Walker(self.conditions, self.lowered, path)
        self.points = list(chain.from_iterable(map(walker.points, self.routines)))
        self.main = [point for point in self.points if not point.routine.frame]
        self.own = [routine for routine in routines if not routine.frame]
        self.lines = [(line, self.place(line)) for routine in self.own for line in routine.lines]
        self.calls = list(block_calls(self.main))
        self.axes = slots_of(self.calls)
        self.owners = self._owners()
        self._stubbed = {str(getattr(stub, "to", "")).upper() for stub in spec.stubs.values()}

    @cached_property
    def read(self) -> frozenset[str]:
        """Paths that the program reads, in capitals, such as COUNT.DN."""
        return frozenset(path_of(mention.where) for mention in self.mentions if mention.reads)

    @cached_property
    def written_members(self) -> frozenset[str]:
        """Instance members that the calling program writes, in capitals."""
        mentions = (
            mention
            for point in self.main
            for mention in mentions_of(self.lowered.sites[point.step.site], point.step)
        )
        return frozenset(path_of(mention.where).partition(".")[2] for mention in mentions if mention.writes)

    def place(self, line: LoweredLine) -> FileLine:
        """Return the file and line number of a rung or statement."""
        return place_at(line.origin, self.path)

    def declaration(self, name: str) -> FileLine:
        """Return the line that declares a name."""
        return FileLine(str(self.path), self._declaration_line(name))

    def is_recorded(self, tag: str) -> bool:
        """Whether the rack file records a tag, or a stub uses it."""
        if tag.upper() in self._stubbed:
            return True
        patterns = (pattern.upper().partition(".")[0] for pattern in self.spec.tags)
        return any(fnmatch(f"{tag}.".upper(), f"{pattern}.") for pattern in patterns)

    def _owners(self) -> dict[str, str]:
        """Return the task of each program, by name in capitals; empty if only one task has programs."""
        schedule = self.lowered.schedule
        tasks = [task for task in schedule.tasks if task.programs] if schedule is not None else []
        if len(tasks) < 2:
            return {}
        return {program.name.upper(): task.task.name for task in tasks for program in task.programs}
