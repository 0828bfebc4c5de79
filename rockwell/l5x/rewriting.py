"""Edits rungs in an L5X; the bytes of all other elements stay as Studio 5000 wrote them.

An edited rung gets a new text and keeps its comment. Rungs after a new or a deleted one get other
numbers. New tags are base tags of their program.
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
        data: an L5X that can be read, see `xml.document`.
        edits: their texts are in the program's notation, see `EditedProgram`.
        file: its name, for errors.

    Raises:
        LadderError: the file can't be read, has no such rung or program, or a routine has online edits of
            its own.
    """
    text = L5xText(data, file)
    by_routine: dict[str, list[RungEdit]] = {}
    for edit in edits:
        by_routine.setdefault(edit.routine, []).append(edit)
    splices: list[Splice] = []
    changes: list[FileChange] = []
    for name, routine_edits in by_routine.items():
        routine = _EditedRoutine(text, file, name)
        splices += routine.edited(routine_edits)
        changes += routine.changes
    for program in dict.fromkeys(tag.program for tag in tags):
        new_tags = [tag for tag in tags if tag.program == program]
        splices.append(_declared(text, _program(text, file, program), new_tags))
        changes += (FileChange(f"tag {tag.name}", "it is new") for tag in new_tags)
    return Rewritten(text.spliced(splices), tuple(changes))


def _program(text: L5xText, file: str, name: str) -> Span:
    """Return the program with a name; for an empty name, the only program."""
    programs = text.programs
    matches = list(defined(programs, name)) if name or len(programs) != 1 else programs
    if not matches:
        raise LadderError(f"{file} has no program {name}{_instead(text, programs)}")
    return matches[0]


def _instead(text: L5xText, there: Sequence[Span]) -> str:
    """Return names and lines of the elements that the file has instead, as the end of a message."""
    spans = ", ".join(f"{span.name} (line {text.line(span.begin)})" for span in there[:5])
    return f": it has {spans}{', …' if len(there) > 5 else ''}" if there else ""


class _EditedRoutine:
    """The rungs of a routine."""

    def __init__(self, text: L5xText, file: str, name: str) -> None:
        """Find the routine; raise a LadderError if it does not exist or is being edited in Studio 5000."""
        self._text, self._name = text, name
        program = _program(text, file, program_of(name))
        routines = [routine for group in program.all("Routines") for routine in group.all("Routine")]
        span = next(defined(routines, name.rpartition(".")[2]), None)
        if span is None:
            raise LadderError(f"{file} has no routine {name}{_instead(text, routines)}")
        self._routine, self._where = span, f"{file}:{text.line(span.begin)}"
        self._content = span.child("RLLContent")
        if self._content is None and any(child.tag.endswith("Content") for child in span.children):
            raise LadderError(f"{self._where}: routine {name} has no rungs")
        self._rungs = [] if self._content is None else self._content.children
        if any(rung.attributes.get("Type", NORMAL).upper() != NORMAL for rung in self._rungs):
            reason = f"routine {name} has online edits in the file: finalize them in Studio 5000 first"
            raise LadderError(f"{self._where}: {reason}")
        self.changes: list[FileChange] = []

    def edited(self, edits: Sequence[RungEdit]) -> Iterator[Splice]:
        """Yield the splices for some edits."""
        by_rung = {rung_edit.rung: rung_edit for rung_edit in edits}
        self._check_numbers(by_rung)
        first = by_rung.get(BEFORE_FIRST)
        moved = 0
        if first is not None and first.texts:
            yield from self._before_first(first.texts)
            moved = len(first.texts)
        for place, rung in enumerate(self._rungs):
            number, edit = _number(rung, place), by_rung.get(place)
            if edit is not None and not edit.texts:
                self._note(number, "it is deleted")
                yield self._text.without(rung)
                moved -= 1
                continue
            if moved:
                self._note(number, f"it is rung {number + moved} now")
                yield self._text.attribute(rung, "Number", str(number + moved))
            if edit is not None:
                yield from () if edit.keeps else self._edited_text(number, rung, edit.texts[0])
                yield from self._new_after(rung, edit.texts[1:], number + moved + 1)
                moved += len(edit.texts) - 1

    def _check_numbers(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            if not BEFORE_FIRST <= number < len(self._rungs):
                text = f"routine {self._name} has {len(self._rungs)} rungs, none is {number}"
                raise LadderError(f"{self._where}: {text}")

    def _note(self, number: int, why: str) -> None:
        self.changes.append(FileChange(f"{self._name} rung {number}", why))

    def _edited_text(self, number: int, rung: Span, text: str) -> Iterator[Splice]:
        """Yield what gives a rung another text, with the blanks around it as they are."""
        self._note(number, "its text is edited")
        element, content = rung.child("Text"), self._text.characters(text)
        if element is None:
            yield self._text.last(rung, b"<Text>" + content + b"</Text>")
        elif element.is_empty:
            yield self._text.last(element, content)
        else:
            yield self._text.content(element, content)

    def _before_first(self, texts: Sequence[str]) -> Iterator[Splice]:
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
        new_rungs = [self._between + self._rung(text, begin + index) for index, text in enumerate(texts)]
        if new_rungs:
            yield Splice(rung.end, rung.end, b"".join(new_rungs))

    @property
    def _between(self) -> bytes:
        """The blanks between rungs."""
        if self._content is None or not self._rungs:
            return self._text.newline
        return self._text.blanks_before(self._rungs[0])

    def _rung(self, text: str, place: int) -> bytes:
        """Return a new rung, indented like the other rungs."""
        blanks = self._between
        self.changes.append(FileChange(f"{self._name} rung {place}", "it is new"))
        parts = (
            b'<Rung Number="%d" Type="N">' % place,
            b"<Text>", self._text.characters(text), b"</Text>", b"</Rung>",
        )  # fmt: skip
        return blanks.join(parts)


def _number(rung: Span, place: int) -> int:
    """Return the number of a rung in the file; its place if it has none."""
    number = number_of(rung.attributes.get("Number", ""))
    return place if number is None else number


def _declared(text: L5xText, program: Span, new: Sequence[NewTag]) -> Splice:
    """Return the splice that adds tags to a program."""
    tags = program.child("Tags")
    first = tags or program
    blanks = text.blanks_before(first)
    content = b"".join(
        f'<Tag Name="{escape(tag.name)}" TagType="Base" DataType="{escape(tag.type)}" Constant="false" '
        f'ExternalAccess="Read/Write"/>'.encode()
        + blanks
        for tag in new
    )
    if tags is not None:
        return text.last(tags, blanks * tags.is_empty + content)
    content = b"<Tags>" + blanks + content + b"</Tags>" + blanks
    routines = program.child("Routines")
    return Splice(routines.begin, routines.begin, content) if routines else text.last(program, content)
