"""Extracts a program or a routine from an L5X, as an L5X for partial import.

The bytes of the remaining parts do not change. Of the controller only data types, add-on instructions and
tags remain; they become the context of the exported object. Modules, tasks and all else are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from scanrack.ladder.model.errors import LadderError

from .xml.spans import L5xText, Span, Splice, defined

_CONTEXT = ("DataTypes", "AddOnInstructionDefinitions", "Tags", "Programs")
_OPTIONS = (
    *("References", "NoRawData", "L5KData", "DecoratedData", "Context", "Dependencies"),
    *("ForceProtectedEncoding", "AllProjDocTrans"),
)
"""Export options, in the order of a file."""

_NEEDED = frozenset({"References", "Context", "Dependencies"})
_OF_ANOTHER_TARGET = ("TargetSubType", "TargetClass", "TargetRevision", "TargetLastEdited", "TargetCount")


def partial_l5x(data: bytes, name: str, file: str = "the L5X") -> bytes:
    """Return a program (`Main`) or routine (`Main.Sequence`) of an L5X as an L5X.

    A file that already exports exactly that is returned unchanged.

    Raises:
        LadderError: the file can't be read, or has no such object.
    """
    text = L5xText(data, file)
    owner, _, routine_name = name.partition(".")
    program = _found("program", text.programs, owner)
    routine = _found("routine", _routines(program), routine_name) if routine_name else None
    if _is_target(text.root, program, routine):
        return data
    return text.spliced(_Extraction(text, program, routine).splices())


def _routines(program: Span) -> list[Span]:
    return [child for group in program.all("Routines") for child in group.children]


def _found(what: str, among: list[Span], name: str) -> Span:
    for item in defined(among, name):
        return item
    names = ", ".join(dict.fromkeys(item.name for item in among)) or "none"
    raise LadderError(f"no {what} {name!r}; choose from {names}")


def _is_target(root: Span, program: Span, routine: Span | None) -> bool:
    target = program if routine is None else routine
    return root.attributes.get("TargetType") == target.tag and target.attributes.get("Use") == "Target"


class _Extraction:
    def __init__(self, text: L5xText, program: Span, routine: Span | None) -> None:
        self._text, self._program, self._routine = text, program, routine

    def splices(self) -> Iterator[Splice]:
        """Yield the splices that turn the whole file into the partial one."""
        controller = self._text.controller
        assert controller is not None
        yield from self._head()
        yield from self._changed(controller, {"Use": "Context"})
        for child in controller.children:
            if child.tag not in _CONTEXT:
                yield self._text.without(child)
                continue
            yield from self._changed(child, {"Use": "Context"})
            for program in child.children if child.tag == "Programs" else ():
                if program is self._program:
                    yield from self._of_program(program)
                else:
                    yield self._text.without(program)

    def _head(self) -> Iterator[Splice]:
        """Yield the splices for the attributes of the root element."""
        root, target = self._text.root, self._routine or self._program
        present = root.attributes.get("ExportOptions", "").split()
        options = sorted(_NEEDED | set(present), key=lambda each: (*_OPTIONS, *present).index(each))
        attributes: dict[str, str | None] = dict.fromkeys(_OF_ANOTHER_TARGET)
        if self._routine is not None:
            attributes["TargetSubType"] = self._routine.attributes.get("Type")
        attributes |= {"TargetName": target.name, "TargetType": target.tag, "ContainsContext": "true"}
        attributes["ExportOptions"] = " ".join(options)
        yield from self._changed(root, attributes)

    def _changed(self, span: Span, attributes: Mapping[str, str | None]) -> Iterator[Splice]:
        for name, value in attributes.items():
            if span.attributes.get(name) != value:
                yield self._text.attribute(span, name, value)

    def _of_program(self, program: Span) -> Iterator[Splice]:
        is_whole = self._routine is None
        yield from self._changed(program, {"Use": "Target" if is_whole else "Context"})
        for child in program.children:
            if is_whole:
                yield from self._plain([child])
            elif child.tag in ("Tags", "Routines"):
                yield from self._changed(child, {"Use": "Context"})
            else:
                yield self._text.without(child)
        for routine in _routines(program):
            if is_whole:
                yield from self._plain([routine])
            elif routine is self._routine:
                yield from self._changed(routine, {"Use": "Target"})
            elif routine.attributes.get("Use") != "Reference":
                yield self._text.without(routine)
                continue
            for content in routine.children:
                yield from self._plain(content.children)

    def _plain(self, spans: Iterable[Span]) -> Iterator[Splice]:
        """Yield splices that remove the Use attribute, which parts have in an export of another target."""
        for span in spans:
            if span.attributes.get("Use", "Reference") != "Reference":
                yield self._text.attribute(span, "Use", None)
