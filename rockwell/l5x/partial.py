"""Extracts a program or a routine from an L5X, as an L5X for partial import.

The bytes of the remaining parts do not change. Only the data types, add-on instructions and tags of the
controller remain; they become the context of the exported object. Modules, tasks and other parts are removed.
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

    A file that already exports exactly this object remains unchanged.

    Raises:
        LadderError: the file can't be read, or has no such object.
    """
    text = L5xText(data, file)
    owner, _, routine_name = name.partition(".")
    program = _find("program", text.programs, owner)
    routine = _find("routine", _routines(program), routine_name) if routine_name else None
    if _is_target(text.root, program, routine):
        return data
    return text.spliced(_Extraction(text, program, routine).splices())


def _routines(program: Span) -> list[Span]:
    return [child for group in program.all("Routines") for child in group.children]


def _find(kind: str, spans: list[Span], name: str) -> Span:
    """Return the first element with a name; raise a LadderError that lists the names."""
    for span in defined(spans, name):
        return span
    names = ", ".join(dict.fromkeys(span.name for span in spans)) or "none"
    raise LadderError(f"no {kind} {name!r}; choose from {names}")


def _is_target(root: Span, program: Span, routine: Span | None) -> bool:
    target = program if routine is None else routine
    return root.attributes.get("TargetType") == target.tag and target.attributes.get("Use") == "Target"


class _Extraction:
    """The extraction of a program, or of one of its routines."""

    def __init__(self, text: L5xText, program: Span, routine: Span | None) -> None:
        self._text, self._program, self._routine = text, program, routine

    def splices(self) -> Iterator[Splice]:
        """Yield the splices that turn the whole file into the partial one."""
        controller = self._text.controller
        assert controller is not None
        yield from self._root_splices()
        yield from self._with_attributes(controller, {"Use": "Context"})
        for child in controller.children:
            if child.tag not in _CONTEXT:
                yield self._text.without(child)
                continue
            yield from self._with_attributes(child, {"Use": "Context"})
            for program in child.children if child.tag == "Programs" else ():
                if program is self._program:
                    yield from self._program_splices(program)
                else:
                    yield self._text.without(program)

    def _root_splices(self) -> Iterator[Splice]:
        """Yield the splices for the attributes of the root element."""
        root, target = self._text.root, self._routine or self._program
        present = root.attributes.get("ExportOptions", "").split()
        options = sorted(_NEEDED | set(present), key=(*_OPTIONS, *present).index)
        attributes: dict[str, str | None] = dict.fromkeys(_OF_ANOTHER_TARGET)
        if self._routine is not None:
            attributes["TargetSubType"] = self._routine.attributes.get("Type")
        attributes |= {"TargetName": target.name, "TargetType": target.tag, "ContainsContext": "true"}
        attributes["ExportOptions"] = " ".join(options)
        yield from self._with_attributes(root, attributes)

    def _with_attributes(self, span: Span, attributes: Mapping[str, str | None]) -> Iterator[Splice]:
        """Yield the splices that set attributes, or remove attributes whose value is None."""
        for name, value in attributes.items():
            if span.attributes.get(name) != value:
                yield self._text.attribute(span, name, value)

    def _program_splices(self, program: Span) -> Iterator[Splice]:
        """Yield the splices for the program of the exported object."""
        is_whole = self._routine is None
        yield from self._with_attributes(program, {"Use": "Target" if is_whole else "Context"})
        for child in program.children:
            if is_whole:
                yield from self._without_use([child])
            elif child.tag in ("Tags", "Routines"):
                yield from self._with_attributes(child, {"Use": "Context"})
            else:
                yield self._text.without(child)
        for routine in _routines(program):
            if is_whole:
                yield from self._without_use([routine])
            elif routine is self._routine:
                yield from self._with_attributes(routine, {"Use": "Target"})
            elif routine.attributes.get("Use") != "Reference":
                yield self._text.without(routine)
                continue
            for content in routine.children:
                yield from self._without_use(content.children)

    def _without_use(self, spans: Iterable[Span]) -> Iterator[Splice]:
        """Yield the splices that remove the Use attributes, which mark another export's target or context."""
        for span in spans:
            if span.attributes.get("Use", "Reference") != "Reference":
                yield self._text.attribute(span, "Use", None)
