"""Edits rungs in an L5X; all other elements remain byte for byte as Studio 5000 wrote them.

An edited rung gets a new text and keeps its comment. Rungs after a new or deleted rung are renumbered.
New tags are base tags of their program.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from scanrack.ladder.lowering.edited import BEFORE_FIRST, FileChange, NewTag, Rewritten, RungEdit
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.tags import program_of

from .edits import NORMAL
from .xml.elements import number_of
from .xml.spans import L5xText, Span, Splice, defined


def rewritten_l5x(
    data: bytes, edits: Iterable[RungEdit], tags: Sequence[NewTag] = (), file: str = "the L5X"
) -> Rewritten:
    """Return an L5X with edited rungs and new tags, and a list of its changes.

    Args:
        data: a valid L5X, see `xml.document`.
        edits: edited rungs, with texts in the notation of `EditedProgram`.
        file: the name of the file, for errors.

    Raises:
        LadderError: the file can't be read or has no such rung or program, or a routine has online edits.
    """
    text = L5xText(data, file)
    by_routine: dict[str, list[RungEdit]] = {}
    for edit in edits:
        by_routine.setdefault(edit.routine, []).append(edit)
    splices: list[Splice] = []
    changes: list[FileChange] = []
    for name, routine_edits in by_routine.items():
        routine = _EditedRoutine(text, file, name)
        splices += routine.splices(routine_edits)
        changes += routine.changes
    for program in dict.fromkeys(tag.program for tag in tags):
        new_tags = [tag for tag in tags if tag.program == program]
        splices.append(_declaring(text, _program(text, file, program), new_tags))
        changes += (FileChange(f"tag {tag.name}", "it is new") for tag in new_tags)
    return Rewritten(text.spliced(splices), tuple(changes))


def _program(text: L5xText, file: str, name: str) -> Span:
    """Return the program with a name; for an empty name, return the only program."""
    programs = text.programs
    matches = list(defined(programs, name)) if name or len(programs) != 1 else programs
    if not matches:
        raise LadderError(f"{file} has no program {name}{_alternatives(text, programs)}")
    return matches[0]


def _alternatives(text: L5xText, spans: Sequence[Span]) -> str:
    """Return the end of a message: the names and lines of the file's elements; "" if it has none."""
    names = ", ".join(f"{span.name} (line {text.line(span.begin)})" for span in spans[:5])
    return f": it has {names}{', …' if len(spans) > 5 else ''}" if spans else ""


class _EditedRoutine:
    """The rungs of a routine."""

    def __init__(self, text: L5xText, file: str, name: str) -> None:
        """Find the routine; raise a LadderError if it does not exist or is being edited in Studio 5000."""
        self._text, self._name = text, name
        program = _program(text, file, program_of(name))
        routines = [routine for group in program.all("Routines") for routine in group.all("Routine")]
        span = next(defined(routines, name.rpartition(".")[2]), None)
        if span is None:
            raise LadderError(f"{file} has no routine {name}{_alternatives(text, routines)}")
        self._routine, self._location = span, f"{file}:{text.line(span.begin)}"
        self._content = span.child("RLLContent")
        if self._content is None and any(child.tag.endswith("Content") for child in span.children):
            raise LadderError(f"{self._location}: routine {name} has no rungs")
        self._rungs = [] if self._content is None else self._content.children
        if any(rung.attributes.get("Type", NORMAL).upper() != NORMAL for rung in self._rungs):
            reason = f"routine {name} has online edits in the file: finalize them in Studio 5000 first"
            raise LadderError(f"{self._location}: {reason}")
        self.changes: list[FileChange] = []

    def splices(self, edits: Sequence[RungEdit]) -> Iterator[Splice]:
        """Yield the splices for edits of this routine, and record the changes."""
        by_rung = {edit.rung: edit for edit in edits}
        self._check_numbers(by_rung)
        first = by_rung.get(BEFORE_FIRST)
        shift = 0  # the new number of the next rung, minus its number in the file
        if first is not None and first.texts:
            yield from self._before_first(first.texts)
            shift = len(first.texts)
        for index, rung in enumerate(self._rungs):
            number, edit = _number(rung, index), by_rung.get(index)
            if edit is not None and not edit.texts:
                self._note(number, "it is deleted")
                yield self._text.without(rung)
                shift -= 1
                continue
            if shift:
                self._note(number, f"it is rung {number + shift} now")
                yield self._text.attribute(rung, "Number", str(number + shift))
            if edit is not None:
                if not edit.keeps:
                    yield self._edited_text(number, rung, edit.texts[0])
                yield from self._new_after(rung, edit.texts[1:], number + shift + 1)
                shift += len(edit.texts) - 1

    def _check_numbers(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            if not BEFORE_FIRST <= number < len(self._rungs):
                text = f"routine {self._name} has {len(self._rungs)} rungs, none is {number}"
                raise LadderError(f"{self._location}: {text}")

    def _note(self, number: int, change: str) -> None:
        self.changes.append(FileChange(f"{self._name} rung {number}", change))

    def _edited_text(self, number: int, rung: Span, text: str) -> Splice:
        """Return the splice that changes the text of a rung; white space around the text remains."""
        self._note(number, "its text is edited")
        element, content = rung.child("Text"), self._text.characters(text)
        if element is None:
            return self._text.last(rung, b"<Text>" + content + b"</Text>")
        if element.is_empty:
            return self._text.last(element, content)
        return self._text.content(element, content)

    def _before_first(self, texts: Sequence[str]) -> Iterator[Splice]:
        """Yield the splice that inserts rungs at the beginning, even in a routine without rungs."""
        begin = _number(self._rungs[0], 0) if self._rungs else 0
        blanks = self._between
        content = b"".join(self._rung(text, begin + index) + blanks for index, text in enumerate(texts))
        if self._rungs:
            yield Splice(self._rungs[0].begin, self._rungs[0].begin, content)
        elif self._content is not None:
            yield self._text.last(self._content, content)
        else:
            yield self._text.last(self._routine, b"<RLLContent>%s%s</RLLContent>" % (blanks, content))

    def _new_after(self, rung: Span, texts: Sequence[str], begin: int) -> Iterator[Splice]:
        """Yield the splice that inserts rungs after a rung, if there are any."""
        new_rungs = [self._between + self._rung(text, begin + index) for index, text in enumerate(texts)]
        if new_rungs:
            yield Splice(rung.end, rung.end, b"".join(new_rungs))

    @property
    def _between(self) -> bytes:
        """The white space between rungs."""
        if self._content is None or not self._rungs:
            return self._text.newline
        return self._text.blanks_before(self._rungs[0])

    def _rung(self, text: str, number: int) -> bytes:
        """Return a new rung, indented like the other rungs, and add it to the list of changes."""
        self._note(number, "it is new")
        return self._between.join((
            b'<Rung Number="%d" Type="N">' % number,
            b"<Text>", self._text.characters(text), b"</Text>", b"</Rung>",
        ))  # fmt: skip


def _number(rung: Span, index: int) -> int:
    """Return the number of a rung in the file; its index if it has no number."""
    number = number_of(rung.attributes.get("Number", ""))
    return index if number is None else number


def _declaring(text: L5xText, program: Span, new_tags: Sequence[NewTag]) -> Splice:
    """Return the splice that adds tags to a program."""
    tags = program.child("Tags")
    blanks = text.blanks_before(tags or program)
    content = b"".join(
        f'<Tag Name="{escape(tag.name)}" TagType="Base" DataType="{escape(tag.type)}" Constant="false" '
        f'ExternalAccess="Read/Write"/>'.encode()
        + blanks
        for tag in new_tags
    )
    if tags is not None:
        return text.last(tags, blanks * tags.is_empty + content)
    content = b"<Tags>" + blanks + content + b"</Tags>" + blanks
    routines = program.child("Routines")
    return Splice(routines.begin, routines.begin, content) if routines else text.last(program, content)
