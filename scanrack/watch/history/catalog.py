"""A ladder program as pages show it: its routines, rungs and tags, and the drawings of a routine."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from scanrack.io_images.tag_names import TEXT
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.crossref import CrossReference
from scanrack.ladder.debug.replay import Truths
from scanrack.ladder.debug.tag_values import tag_values
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.draw import LiveRung, captions_of, live_chart, live_diagram, live_rung, power
from scanrack.ladder.lowering.checks import calls_of
from scanrack.ladder.model.chart import Chart
from scanrack.ladder.model.drawing import Drawing
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_expression
from scanrack.ladder.model.operands import Group, Place
from scanrack.ladder.model.resolver import Resolver, address_in
from scanrack.ladder.model.routine import Routine, element_of
from scanrack.ladder.model.tags import Alias, Tag, program_of, scoped
from scanrack.ladder.model.tree import Address, Rung
from scanrack.ladder.model.types import Structure
from scanrack.ladder.run.view import Tags
from scanrack.runtime.loop.faults import Fault

Json = dict[str, Any]

MOST_HITS = 200
"""Maximum number of search results."""

COLUMNS = range(40, 161)
"""Allowed widths of a rung, in columns."""


@dataclass(frozen=True, slots=True)
class PageRoutine:
    """The contents of a routine on a page."""

    name: str
    rungs: Mapping[int, Rung]  # rungs by number; empty for structured text
    lines: tuple[int, ...]  # line numbers of structured text
    names: tuple[str, ...]  # tags

    def power(self, truths: Truths) -> dict[str, str]:
        """Return the power in the rungs and lines by `ROUTINE.NUMBER`, see `ladder.draw.power`."""
        name = self.name.upper()
        powers = {}
        for number, rung in self.rungs.items():
            powers[f"{self.name}.{number}"] = power(rung, truths.get((name, number)))
        for number in self.lines:
            truth = truths.get((name, number))
            powers[f"{self.name}.{number}"] = "1" if truth and truth[-1] else "0"
        return powers


def kind_of(routine: Routine) -> str:
    """Return the language of a routine for pages."""
    if routine.chart is not None:
        return "sfc"
    if routine.statements is None:
        return "ladder"
    return "st" if routine.drawing is None else "fbd"


NOTHING_SHOWN = PageRoutine("", rungs={}, lines=(), names=())


class Catalog:
    """A ladder program for pages."""

    def __init__(self, program: LadderLogic) -> None:
        self._program = program
        self._lowered = program.build()
        self._layout = self._lowered.layout
        self._resolver = Resolver(self._layout)
        self._captions = captions_of(program)
        self._tags = WatchedEngine(program.build(), program.scanner).tags

    def routines(self) -> list[Json]:
        """Return the routines for `hello`, each with the routines that it calls."""
        names = {routine.name.upper(): routine.name for routine in self._program.routines}
        called = {
            name: [names[callee] for callee in dict.fromkeys(calls_of(lowered)) if callee in names]
            for name, lowered in self._lowered.routines.items()
        }
        return [
            {
                "name": routine.name,
                "kind": kind_of(routine),
                "comment": routine.comment,
                "lines": len(routine.numbers),
                "calls": called.get(routine.name.upper(), []),
            }
            for routine in self._program.routines
        ]

    def tags(self) -> list[Json]:
        """Return all single values and aliases for `hello`. Pages request array elements by name."""
        comments = {
            declaration.name.upper(): declaration.comment
            for declaration in self._layout.declarations.values()
            if isinstance(declaration, Tag)
        }
        rows = []
        for tag in tag_values(self._layout, ["*"]) if self._layout.tags() else []:
            stem = tag.name.split("[")[0]  # shortened to the next declared name: members have no comment
            while stem and stem.upper() not in comments:
                stem = stem.rpartition(".")[0]
            rows.append(
                {
                    "name": tag.name,
                    "type": f"{tag.type}[{tag.length}]" if tag.length else tag.type,
                    "description": comments.get(stem.upper(), ""),
                    "writable": not tag.length and tag.type != TEXT,
                }
            )
        return rows + list(self._aliases())

    def _aliases(self) -> Iterator[Json]:
        """Yield the aliases of single values; an alias of an image word or bit has its address."""
        for declaration in self._layout.declarations.values():
            if not isinstance(declaration, Alias) or not self.has(declaration.name):
                continue
            place = self._resolver.address(Address(declaration.name))
            if not isinstance(place, Place):
                continue
            address_field = {} if place.address is None else {"address": place.address}
            described = declaration.comment or str(declaration.target)
            row = {"name": declaration.name, "type": place.type.name, "description": described}
            yield row | {"writable": not address_field} | address_field

    def _groups(self) -> Iterator[Json]:
        """Yield the structures, since `tags` lists only their members."""
        for declaration in self._layout.declarations.values():
            if (
                isinstance(declaration, Tag)
                and isinstance(declaration.type, Structure)
                and not declaration.type.is_string
            ):
                yield {
                    "name": declaration.name,
                    "type": declaration.type.name,
                    "description": declaration.comment,
                }

    def addresses(self, names: Iterable[str]) -> dict[str, str]:
        """Return the name for forcing each tag, if it differs: an address, or the target of an alias."""
        addresses = {name: self._forced_as(name) for name in names}
        return {name: address for name, address in addresses.items() if address not in (None, name)}

    def _forced_as(self, name: str) -> str | None:
        with suppress(LadderError):
            return address_in(self._resolver, name) or self._resolver.base_name(name)
        return None

    def show(self, name: str, columns: int, *, operands: bool = False) -> tuple[PageRoutine, Json]:
        """Return a routine's contents, and the answer with its drawing; for `operands` see `live_rung`.

        Raises:
            ValueError: the routine does not exist.
        """
        routines = {routine.name.upper(): routine for routine in self._program.routines}
        routine = routines.get(name.upper())
        if routine is None:
            names = ", ".join(routine.name for routine in self._program.routines)
            raise ValueError(f"no routine {name}; choose from {names}")
        if routine.chart is not None:
            page_routine, answer = self._chart(routine, routine.chart)
        elif routine.drawing is not None:
            page_routine, answer = self._diagram(routine, routine.drawing)
        elif routine.statements is not None:
            page_routine, answer = self._text(routine)
        else:
            page_routine, answer = self._rungs(routine, columns, operands=operands)
        return page_routine, answer | {"addresses": self.addresses(page_routine.names)}

    def _chart(self, routine: Routine, chart: Chart) -> tuple[PageRoutine, Json]:
        """Return the tags of a sequential function chart, and the answer with its drawing; see `show`."""
        program = program_of(routine.name)
        resolver = Resolver(self._layout, program)
        drawn = live_chart(chart, routine.name, lambda address: self._name_of(resolver, program, address))
        answer = {"routine": routine.name, "chart": drawn.svg, "notes": list(chart.notes)}
        return PageRoutine(routine.name, rungs={}, lines=(), names=drawn.names), answer

    def _diagram(self, routine: Routine, drawing: Drawing) -> tuple[PageRoutine, Json]:
        """Return the tags of a function block diagram, and the answer with its drawing; see `show`."""
        program = program_of(routine.name)
        resolver = Resolver(self._layout, program)

        def tag_of(text: str) -> tuple[str, bool] | None:
            """Return the tag to which a pin refers, and whether it is a bit; None for any other text."""
            try:
                address = parse_expression(text)
            except LadderError:  # the name of a pin need not be a tag
                return None
            name = self._name_of(resolver, program, address) if isinstance(address, Address) else None
            if name is None or not isinstance(address, Address):
                return None
            place = resolver.address(address)
            return name, isinstance(place, Place) and (place.type.is_bool or place.bit is not None)

        drawn = live_diagram(drawing.sheets, routine.name, tag_of)
        answer = {"routine": routine.name, "diagram": drawn.svg}
        return PageRoutine(routine.name, rungs={}, lines=(), names=drawn.names), answer

    def _rungs(self, routine: Routine, columns: int, *, operands: bool) -> tuple[PageRoutine, Json]:
        """Return the rungs of a routine with their tags, and the answer with their drawings; see `show`."""
        names: dict[str, None] = {}
        drawn = []
        for number, rung in enumerate(routine.rungs):
            live = self.draw(rung, routine.name, f"{routine.name}.{number}", columns, operands=operands)
            names.update(dict.fromkeys(live.names))
            origin = rung.origin
            drawn.append(
                {
                    "number": number,
                    "svg": live.svg,
                    "comment": rung.comment,
                    "file": Path(str(origin.file)).name if origin.file else "",
                    "line": origin.line,
                    "text": str(rung),
                }
            )
        page_routine = PageRoutine(
            routine.name, rungs=dict(enumerate(routine.rungs)), lines=(), names=tuple(names)
        )
        return page_routine, {"routine": routine.name, "rungs": drawn}

    def draw(self, rung: Rung, routine: str, ident: str, columns: int, *, operands: bool = True) -> LiveRung:
        """Draw a rung of a routine; the ids of its elements begin with `ident`."""
        program = program_of(routine)
        resolver = Resolver(self._layout, program)
        names = lambda address: self._name_of(resolver, program, address)  # noqa: E731
        return live_rung(
            rung, ident, columns, self._captions, names, specs=self._program.builtin, operands=operands
        )

    def _text(self, routine: Routine) -> tuple[PageRoutine, Json]:
        """Return the lines of structured text with their tags, and the answer with the text; see `show`."""
        names: dict[str, None] = {}
        lines = []
        for statement in routine.statements or ():
            for number, text in statement.numbered():
                own_names = self._names_in(text, program_of(routine.name))
                names.update(dict.fromkeys(own_names))
                lines.append({"number": number, "text": text, "names": own_names})
        page_routine = PageRoutine(routine.name, rungs={}, lines=tuple(routine.numbers), names=tuple(names))
        return page_routine, {"routine": routine.name, "text": lines}

    def _names_in(self, text: str, program: str) -> list[str]:
        """Return the full names of the single-value tags in a text, without duplicates."""
        names: dict[str, None] = {}
        for name in _words(text):
            qualified = self._qualified(program, name)
            if qualified is not None and self._is_single(qualified):
                names[qualified] = None
        return list(names)

    def _name_of(self, resolver: Resolver, program: str, address: Address) -> str | None:
        """Return the full name of an address; None if it is unknown or has more than one value."""
        try:
            place = resolver.address(address)
        except LadderError:
            return None
        if isinstance(place, Group):
            return None
        qualified = self._qualified(program, address.name) or address.name
        return str(Address(qualified, address.steps))

    def _qualified(self, program: str, name: str) -> str | None:
        """Return the full name of a tag or member of a program or controller; None if not declared."""
        declared = self._layout.declarations
        stem = name.partition(".")[0].partition("[")[0]
        if program and scoped(program, stem).upper() in declared:
            return scoped(program, name)
        return name if stem.upper() in declared else None

    def _is_single(self, name: str) -> bool:
        """Return whether a name refers to a single value, not to a structure or an array."""
        try:
            return isinstance(self._tags[name], (bool, int, float, str))
        except ValueError:
            return False

    @cached_property
    def cross_reference(self) -> CrossReference:
        """The uses of the program's tags."""
        return CrossReference(self._program.build())

    def mentions(self, tag: str) -> list[Json]:
        """Return where a tag is used; raise ValueError for an unknown tag."""
        return [
            {"text": str(use), "rung": f"{use.site.routine}.{use.site.rung}", "tag": tag}
            for use in self.cross_reference.of(tag)
        ]

    def find(self, text: str) -> list[Json]:
        """Return the tags and rungs that contain a text, tags first, ignoring case; see `tag_hits`."""
        folded, hits = text.casefold(), tag_hits([*self.tags(), *self._groups()], text)
        for routine in self._program.routines:
            for number in routine.numbers:
                rung_text = routine.numbered(number)
                comment = routine.rungs[number].comment if routine.rungs else ""
                if folded in f"{rung_text} {comment}".casefold():
                    hits.append({"text": rung_text, "rung": f"{routine.name}.{number}", "tag": None})
        return hits

    def place_of_fault(self, fault: Fault) -> str | None:
        """Return the rung or line of a major fault, such as Main.3; None if unknown."""
        routine, rung = element_of(self._program.routines, fault.site)
        is_known = any(candidate.name == routine for candidate in self._program.routines)
        return f"{routine}.{rung}" if is_known and rung is not None else None

    def tags_of_fault(self, fault: Fault) -> list[str]:
        """Return the tags that the rung or line of a major fault reads."""
        routine, rung = element_of(self._program.routines, fault.site)
        uses = (use for use in self.cross_reference if use.reads and self.has(use.text))
        fault_site = (routine or "").upper(), rung
        names = (use.text for use in uses if (use.site.routine.upper(), use.site.rung) == fault_site)
        return list(dict.fromkeys(names))

    def has(self, name: str) -> bool:
        """Return whether the tag exists."""
        return name in self._tags

    def type_of(self, name: str) -> str | None:
        """Return the type of a tag; "" for a structure or array; None for an unknown tag."""
        if not self.has(name):
            return None
        place = self._tags.where(name)
        return place.type.name if isinstance(place, Place) else ""


def tag_hits(tags: Iterable[Json], text: str) -> list[Json]:
    r"""Return the tags whose name or description contains a text, ignoring case.

    The best matches come first: the same name, a program's tag `\Main.Step` for `Step`, a name that begins
    with the text, a name that contains it, a description.
    """
    folded, hits = text.casefold(), []
    for tag in tags:
        name, details = tag["name"].casefold(), f"{tag['type']}  {tag['description']}".strip()
        if folded in f"{name} {tag['description']} {tag.get('address', '')}".casefold():
            own_name = name.rpartition(".")[2] if name.startswith("\\") else name
            ranks = name == folded, own_name == folded, own_name.startswith(folded), folded in name, True
            order = ranks.index(True)
            row = {"text": f"{tag['name']} : {details}", "says": details, "rung": None, "tag": tag["name"]}
            hits.append((order, row))
    return [hit for _order, hit in sorted(hits, key=lambda ranked: ranked[0])]


def _words(text: str) -> Iterable[str]:
    """Yield the parts of a text that can be names of tags or members."""
    word = ""
    for character in f"{text} ":
        if character.isalnum() or character in "_.[]:\\":
            word += character
        elif word:
            yield word.rstrip(".:")
            word = ""


def value_of(tags: Tags, name: str) -> Any:
    """Return the value of a tag; None for a subscript out of range."""
    try:
        return tags[name]
    except ValueError:
        return None


def shown_value(value: object) -> Any:
    """Return a value for JSON; an infinity or NaN becomes text."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, dict):
        return {key: shown_value(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [shown_value(inner) for inner in value]
    return value
