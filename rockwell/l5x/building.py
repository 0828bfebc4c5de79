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

from .assembly import Parts, does_nothing, owner_of, without
from .report import Report
from .routines import RoutineReader

STAND_IN, DECLARE = "--stand-in", '[stubs] missing_tags = "declare"'
"""The option of a trial, and the setting of a rack, that declare stand-ins."""

_LACKS = re.compile(r"(?:^|: )no routine |(?<! and) has no member ")

ROUNDS = 30
"""Attempts to build after refusals; each refuses at least one rung."""


class Builder:
    """Builds controllers from parts, and removes refused rungs from the parts."""

    def __init__(self, parts: Parts, reader: RoutineReader, report: Report) -> None:
        self._parts, self._reader, self._report = parts, reader, report
        self._emptied: dict[tuple[str, str], set[int]] = {}
        self.offers = ""  # the option that would declare stand-ins; "" if it is on already

    def build(self, of: Callable[[Parts], Parts] = lambda parts: parts) -> Controller | None:
        """Return a controller of the parts that `of` selects; None if nothing can be built."""
        for _ in range(ROUNDS):
            parts = of(self._parts)
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
        key = name.upper()
        if not problem.site.routine.startswith("\\") or key in self._parts.uncalled:
            return False
        self._parts.uncalled.add(key)
        self._report.note(name, f"it is not tried by itself: {problem.text}")
        return True

    def empty(self) -> None:
        """Empty all refused rungs at once."""
        for (owner, routine), numbers in self._emptied.items():
            target = self._routine(owner, routine)
            if target is not None and numbers:
                self._replace(owner, routine, without(target, *numbers))
        self._emptied.clear()

    def refuse(
        self, owner: str, routine: str, number: int, text: str, remedy: str, site: Site = NOWHERE
    ) -> bool:
        """Refuse a rung, which `empty` removes, or a text or chart routine; return whether it existed."""
        routine, _, body = routine.partition(".")  # `Sequence.Step.Action` is a part of routine Sequence
        target = self._routine(owner, routine)
        record = self._reader.record(owner, routine)
        emptied = self._emptied.setdefault((owner.upper(), routine.upper()), set())
        if target is None or record is None or number in emptied or target.statements == ():
            return False
        text, remedy = self._explained(owner, text, remedy, site)
        if target.statements is None and target.chart is None:
            if number >= len(record.rungs) or not target.rungs[number].series:
                return False
            self._reader.refuse(owner, routine, number, text, remedy, site)
            emptied.add(number)
            return True
        place, line = self._place_in(owner, target, body, number, site.line or record.line)
        self._reader.refuse_object(owner, routine, f"{place}{text}", line, remedy)
        self._remove(owner, routine, target)
        return True

    def _place_in(self, owner: str, found: Routine, body: str, number: int, line: int) -> tuple[str, int]:
        """Return the start of a reason, the place in a text or a chart, and the file's line."""
        if found.statements is not None:
            place, line = self._reader.place_of(owner, found.name, number)
            return f"{place}: ", line
        return f"{body.replace('.', ', action ')}, line {number}: " if body else "", line

    def _remove(self, owner: str, routine: str, found: Routine) -> None:
        """Replace a program's routine with a function that does nothing; empty an add-on's routine."""
        part = self._parts.programs.get(owner.upper())
        if part is not None:
            del part.routines[routine.upper()]
            part.functions[routine.upper()] = does_nothing(found.name)
        else:
            self._replace(owner, routine, without(found))

    def _explained(self, owner: str, text: str, remedy: str, site: Site) -> tuple[str, str]:
        """Add to a refusal's text and remedy why a tag is undeclared, or that a stand-in is possible."""
        if site.tag and (why := self._report.why_not(owner, site.tag)):
            return f"tag {site.tag} is not declared: {why}", "correct the tag, or stub the instruction"
        if self.offers and (site.tag or _LACKS.search(text)):
            return text, f"{remedy}; or let {self.offers} stand in for it"
        return text, remedy

    def _refuse_routine(self, owner: str, routine: str, problem: Problem) -> bool:
        target = self._routine(owner, routine)
        if target is None:
            return False
        outcomes = [
            self.refuse(owner, routine, number, problem.text, problem.remedy)
            for number in range(len(target.rungs) or 1)
        ]
        return any(outcomes)

    def _refuse_rest(self, error: LadderError, parts: Parts) -> None:
        reason = str(error).replace("\n", " ")
        owned = [(owner, member, "correct the program") for owner, member in parts.owned()]
        owned += [
            (definition.name, member, "correct the add-on")
            for definition in parts.add_ons.values()
            for member in definition.routines
        ]
        for owner, routine, remedy in owned:
            for number in range(len(routine.rungs) or 1):
                self.refuse(owner, routine.name, number, reason, remedy)
        self.empty()

    def _routine(self, owner: str, routine: str) -> Routine | None:
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            return part.routines[routine.upper()]
        definition = self._parts.add_ons.get(owner.upper())
        return definition.routine(routine) if definition is not None else None

    def _replace(self, owner: str, routine: str, new: Routine) -> None:
        part = self._parts.programs.get(owner.upper())
        if part is not None and routine.upper() in part.routines:
            part.routines[routine.upper()] = new
            return
        definition = self._parts.add_ons[owner.upper()]
        self._parts.add_ons[owner.upper()] = _with_routine(definition, new)

    def _drop_initial(self, tag: str, text: str, parts: Parts) -> bool:
        """Start a tag with zeros if its initial value does not fit; return whether it had one."""
        owner, name = owner_of(tag) if program_of(tag) else ("", tag)
        scope = parts.programs[owner.upper()].declarations if owner else parts.declarations
        for place, declaration in enumerate(scope):
            if isinstance(declaration, Tag) and declaration.initial is not None and declaration.name == name:
                self._report.lose(declaration.name, f"it starts with zeros: {text}")
                scope[place] = replace(declaration, initial=None)
                return True
        return self._drop_defaults(text)

    def _drop_defaults(self, text: str) -> bool:
        is_changed = False
        for key, definition in self._parts.add_ons.items():
            parameters = tuple(replace(parameter, initial=None) for parameter in definition.parameters)
            if parameters != definition.parameters:
                self._parts.add_ons[key] = replace(definition, parameters=parameters)
                self._report.lose(definition.name, f"its defaults are not used: {text}")
                is_changed = True
        return is_changed


def _with_routine(definition: AddOn, new: Routine) -> AddOn:
    routines = [
        new if routine.name.upper() == new.name.upper() else routine for routine in definition.routines
    ]
    return definition.with_routines(tuple(routines))
