"""What a 3601 program must change to run on a networked drive: the words that have another meaning there.

Motion blocks and axis methods do not count as uses: they write the right words for the module in their slot.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from enum import IntFlag

from scanrack.io_images.amci3601.bits import CommandLsw, CommandMsw, StatusLsw, StatusMsw
from scanrack.io_images.drives.differences import CONFIGURATION, Difference, differences
from scanrack.io_images.drives.models import Model
from scanrack.io_images.image import UNSIGNED_MAX
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.ladder import LadderLogic

from .facts import Facts, FileLine, Touch, Violation
from .module_kinds import MODE_CONFIG
from .python.images import Images
from .python.reader import Reader
from .subject import Subject

RULE = "drive-differs"
"""The rule of these findings."""

_IMAGE = re.compile(r"(?:LOCAL:(\d+):([IO])\.DATA|([IO]):(\d+))$")
_PLACE = re.compile(r"\[(\d+)\](?:\.(\d+))?$")
_ENUMS: dict[str, tuple[str, int, type[IntFlag]]] = {
    "CommandMsw": ("O", 0, CommandMsw),
    "CommandLsw": ("O", 1, CommandLsw),
    "StatusMsw": ("I", 0, StatusMsw),
    "StatusLsw": ("I", 1, StatusLsw),
}
_COMMANDS = {
    "RunBlend": CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW,
    "Move": CommandMsw.ABSOLUTE_MOVE,
    "Manual": CommandMsw.MANUAL_CW,
    "FindHome": CommandMsw.FIND_HOME_CW,
}
"""Command classes, each with the bits of command word 0 that it sets."""

Use = tuple[FileLine, str, int, int, str]
"""A use: place, image ("I", "O" or "" for a configuration), word, bits, and the program's name for them."""


def replaced(subject: Subject, model: Model) -> Iterator[Violation]:
    """Yield the uses of a 3601's words that mean something else on a drive, in line order."""
    rows = list(differences(model))
    violations: dict[tuple[FileLine, str], Violation] = {}
    for place, image, word, mask, text in sorted(_uses(subject), key=lambda use: (use[0], use[1:4])):
        if not image:
            violations.setdefault((place, ""), Violation(place, _sentence(text, *CONFIGURATION, model)))
        for row in rows:
            if row.place == (image, word) and row.bits & mask:
                violations.setdefault((place, row.id), Violation(place, _of_row(row, mask, text, model)))
    yield from violations.values()


def _of_row(row: Difference, mask: int, text: str, model: Model) -> str:
    names = row.names(mask)
    named = text if names in text else f"{text} ({names})"
    return _sentence(named, row.on_3601, row.on_drive, row.write, f"{row.id}, {row.source}", model)


def _sentence(text: str, there: str, here: str, write: str, source: str, model: Model) -> str:
    return f"{text}: on a 3601 {there}; on the {model.title} {here}. Write instead: {write} [{source}]"


def _uses(subject: Subject) -> Iterator[Use]:
    slots = {slot.number for _, slot in subject.steppers}
    facts = subject.facts
    yield from _of_tags(facts, slots)
    yield from _of_words(facts, slots)
    for configuration in facts.configurations:
        if configuration.slot is None or configuration.slot in slots:
            yield configuration.place, "", 0, 0, "configuration"
    for command in facts.commands:
        if command.words and command.text in _COMMANDS:
            yield command.place, "O", 0, _COMMANDS[command.text].value, command.text
    if subject.job.program.suffix == ".py" and not isinstance(subject.job.logic, LadderLogic):
        yield from _of_python(subject, slots)


def _of_tags(facts: Facts, slots: set[int]) -> Iterator[Use]:
    """Yield the uses of image bits by address, bit name or alias."""
    for access in facts.accesses:
        image, place = _IMAGE.match(access.variable), _PLACE.match(access.part)
        if image is None or place is None:
            continue
        side, number = (image[2], image[1]) if image[1] else (image[3], image[4])
        acts = side == "I" or access.use is not Touch.UNLATCH  # clearing a bit means the same on a drive
        if acts and int(number) in slots and place[2] is not None:
            yield access.place, side, int(place[1]), 1 << int(place[2]), access.text or access.variable


def _of_words(facts: Facts, slots: set[int]) -> Iterator[Use]:
    """Yield constants that are written to command words."""
    configures = {write.place for write in facts.writes if write.word == 0 and write.sets & MODE_CONFIG}
    for word_write in facts.writes:
        if word_write.slot not in slots or word_write.word >= COMMAND_WORDS or word_write.place in configures:
            continue
        for option in word_write.options:
            yield (
                word_write.place,
                "O",
                word_write.word,
                option & UNSIGNED_MAX,
                word_write.text or f"output word {word_write.word}",
            )


COMMAND_WORDS = 2
"""Words with command bits: MSW and LSW."""


def _of_python(subject: Subject, slots: set[int]) -> Iterator[Use]:
    """Yield bits that a Python program names: `StatusMsw.STOPPED`, `axis.status.STOPPED`, `.bit(0, 3)`."""
    file = str(subject.job.program)
    tree = ast.parse(read_input_text(subject.job.program, TextKind.PYTHON))
    images = Images(Reader(file, tree, {}, Facts()), subject.job.spec)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            owner = ast.unparse(node.value).rpartition(".")[2]
            for name, (image, word, bits) in _ENUMS.items():
                named = owner == name or (owner == "status" and image == "I")
                if named and node.attr in bits.__members__:
                    mask = bits[node.attr].value
                    yield FileLine(file, node.lineno), image, word, mask, ast.unparse(node)
    yield from _of_images(file, tree, images, slots)


def _of_images(file: str, tree: ast.Module, images: Images, slots: set[int]) -> Iterator[Use]:
    for function in (child for child in ast.walk(tree) if isinstance(child, ast.FunctionDef)):
        local = images.locals_of(function)
        for node in ast.walk(function):
            match node:
                case ast.Call(
                    func=ast.Attribute(value=owner, attr="bit" | "set_bit"),
                    args=[ast.Constant(value=int(word)), ast.Constant(value=int(bit)), *_],
                ):
                    kind, slot = images.what(owner, local)
                    if kind in ("inputs", "outputs") and (slot is None or slot in slots):
                        yield FileLine(file, node.lineno), kind[0].upper(), word, 1 << bit, ast.unparse(node)
