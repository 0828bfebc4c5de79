"""Builds a controller from parts, and refuses each rung that can't be built."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import replace

from scanrack.io_images.site import NOWHERE, Site
from scanrack.ladder.lowering.addon import AddOn
from scanrack.ladder.lowering.controller import Controller
from scanrack.ladder.model.errors import BuildError, LadderError, Problem
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.tags import Tag, program_of

from .assembly import Parts, emptied, idle_routine, owner_of
from .report import Report
from .routines import RoutineReader

STAND_IN, DECLARE = "--stand-in", '[stubs] missing_tags = "declare"'
"""The trial option and the rack setting that declare stand-ins."""

_LACKS = re.compile(r"(?:^|: )no routine |(?<! and) has no member ")
"""Reasons of refusals that stand-ins would avoid."""

ROUNDS = 30
"""Maximum number of attempts to build after refusals; each attempt refuses at least one rung."""


class Builder:
    """Builds controllers from parts, and removes refused rungs from the parts."""

    def __init__(self, parts: Parts, reader: RoutineReader, report: Report) -> None:
        self._parts, self._reader, self._report = parts, reader, report
        self._to_empty: dict[tuple[str, str], set[int]] = {}  # rungs, by owner and routine in capitals
        self.stand_in_option = ""  # the option that would declare stand-ins; "" if it is already on

    def build(self, select: Callable[[Parts], Parts] = lambda parts: parts) -> Controller | None:
        """Return a controller with the selected parts, by default all; None if nothing can be built."""
        for _ in range(ROUNDS):
            parts = select(self._parts)
            controller = parts.assemble(self._report)
            try:
                controller.build()
            except BuildError as error:
                if not self._refuse_all(error.problems, parts):
                    self._refuse_rest(error, parts)
                    return None
                self.empty()
            else:
                return controller
        self._refuse_rest(LadderError(f"it can't be built in {ROUNDS} attempts"), parts)
        return None

    def _refuse_all(self, problems: Iterable[Problem], parts: Parts) -> bool:
        """Refuse the rungs and objects with problems; return whether any was refused."""
        is_changed = False
        for problem in problems:
            owner, routine = owner_of(problem.site.routine)
            if problem.site.rung is not None:
                is_changed |= self.refuse(
                    owner, routine, problem.site.rung, problem.text, problem.remedy, problem.site
                )
                is_changed |= parts is not self._parts and self._leave_out(owner, problem)
            elif problem.site.tag:
                is_changed |= self._drop_initial(problem.site.tag, problem.text, parts)
            elif routine:
                is_changed |= self._refuse_routine(owner, routine, problem)
        return is_changed

    def _leave_out(self, name: str, problem: Problem) -> bool:
        """Remove the generated call of an add-on from the harness; return whether it was there."""
        key = name.upper()
        if not problem.site.routine.startswith("\\") or key in self._parts.uncalled:
            return False
        self._parts.uncalled.add(key)
        self._report.note(name, f"it is not tried by itself: {problem.text}")
        return True

    def empty(self) -> None:
        """Empty all rungs refused since the last call, in one pass because copying a long routine is slow."""
        for (owner, routine), numbers in self._to_empty.items():
            target = self._routine(owner, routine)
            if target is not None and numbers:
                self._replace(owner, routine, emptied(target, *numbers))
        self._to_empty.clear()

    def refuse(
        self, owner: str, routine: str, number: int, text: str, remedy: str, site: Site = NOWHERE
    ) -> bool:
        """Refuse a rung, or the whole routine if it is structured text or a chart; return whether it existed.

        `empty` removes refused rungs later. Structured text or a chart is removed immediately.
        """
        routine, _, body = routine.partition(".")  # `Sequence.Step.Action` is a part of routine Sequence
        target = self._routine(owner, routine)
        record = self._reader.record(owner, routine)
        refused_rungs = self._to_empty.setdefault((owner.upper(), routine.upper()), set())
        if target is None or record is None or number in refused_rungs or target.statements == ():
            return False
        text, remedy = self._with_explanation(owner, text, remedy, site)
        if target.statements is None and target.chart is None:
            if number >= len(record.rungs) or not target.rungs[number].series:
                return False
            self._reader.refuse(owner, routine, number, text, remedy, site)
            refused_rungs.add(number)
            return True
        place, line = self._place_in(owner, target, body, number, site.line or record.line)
        self._reader.refuse_object(owner, routine, f"{place}{text}", line, remedy)
        self._remove(owner, routine, target)
        return True

    def _place_in(self, owner: str, target: Routine, body: str, number: int, line: int) -> tuple[str, int]:
        """Return a place in text or a chart as the beginning of a message, and its line in the file."""
        if target.statements is not None:
            place, line = self._reader.place_of(owner, target.name, number)
            return f"{place}: ", line
        return f"{body.replace('.', ', action ')}, line {number}: " if body else "", line

    def _remove(self, owner: str, routine: str, target: Routine) -> None:
        """Replace a program's routine with a function that does nothing; empty an add-on's routine."""
        part = self._parts.programs.get(owner.upper())
        if part is not None:
            del part.routines[routine.upper()]
            part.functions[routine.upper()] = idle_routine(target.name)
        else:
            self._replace(owner, routine, emptied(target))

    def _with_explanation(self, owner: str, text: str, remedy: str, site: Site) -> tuple[str, str]:
        """Return text and remedy; add the reason why a tag is undeclared, or a possible stand-in."""
        reason = self._report.reason_undeclared(owner, site.tag) if site.tag else ""
        if reason:
            return f"tag {site.tag} is not declared: {reason}", "correct the tag, or stub the instruction"
        if self.stand_in_option and (site.tag or _LACKS.search(text)):
            return text, f"{remedy}; or let {self.stand_in_option} stand in for it"
        return text, remedy

    def _refuse_routine(self, owner: str, routine: str, problem: Problem) -> bool:
        """Refuse all rungs of a routine; return whether it existed."""
        target = self._routine(owner, routine)
        if target is None:
            return False
        outcomes = [
            self.refuse(owner, routine, number, problem.text, problem.remedy)
            for number in range(len(target.rungs) or 1)
        ]
        return any(outcomes)

    def _refuse_rest(self, error: LadderError, parts: Parts) -> None:
        """Refuse everything that is not refused yet."""
        reason = str(error).replace("\n", " ")
        for owner, routine in parts.all_routines():
            part = "program" if owner.upper() in self._parts.programs else "add-on"
            for number in range(len(routine.rungs) or 1):
                self.refuse(owner, routine.name, number, reason, f"correct the {part}")
        self.empty()

    def _routine(self, owner: str, routine: str) -> Routine | None:
        """Return a routine of a program, or else of an add-on with that name; None if it does not exist."""
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            return part.routines[routine.upper()]
        definition = self._parts.add_ons.get(owner.upper())
        return definition.routine(routine) if definition is not None else None

    def _replace(self, owner: str, routine: str, new: Routine) -> None:
        """Replace a routine of a program, or else of an add-on, with a new version."""
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            part.routines[routine.upper()] = new
            return
        definition = self._parts.add_ons[owner.upper()]
        self._parts.add_ons[owner.upper()] = _with_routine(definition, new)

    def _drop_initial(self, tag: str, text: str, parts: Parts) -> bool:
        """Remove an initial value that does not fit; return whether there was one to remove."""
        owner, name = owner_of(tag) if program_of(tag) else ("", tag)
        scope = parts.programs[owner.upper()].declarations if owner else parts.declarations
        for index, declaration in enumerate(scope):
            if isinstance(declaration, Tag) and declaration.initial is not None and declaration.name == name:
                self._report.lose(declaration.name, f"it starts with zeros: {text}")
                scope[index] = replace(declaration, initial=None)
                return True
        return self._drop_defaults(text)

    def _drop_defaults(self, text: str) -> bool:
        """Drop the defaults of all add-on parameters; return whether any add-on had defaults."""
        is_changed = False
        for key, definition in self._parts.add_ons.items():
            parameters = tuple(replace(parameter, initial=None) for parameter in definition.parameters)
            if parameters != definition.parameters:
                self._parts.add_ons[key] = replace(definition, parameters=parameters)
                self._report.lose(definition.name, f"its defaults are not used: {text}")
                is_changed = True
        return is_changed


def _with_routine(definition: AddOn, new: Routine) -> AddOn:
    """Return an add-on with a new version of one routine."""
    routines = [
        new if routine.name.upper() == new.name.upper() else routine for routine in definition.routines
    ]
    return definition.with_routines(tuple(routines))
