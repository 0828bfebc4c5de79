"""Finds the words of a 3601 program that have a different meaning on a networked drive.

Motion blocks and axis methods are not reported, because they write the right words for the module in their
slot.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from enum import IntFlag
from typing import NamedTuple

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
from .python.nodes import nodes_in
from .python.reader import Reader
from .subject import Subject

RULE = "drive-differs"
"""The rule of these findings."""

_IMAGE = re.compile(r"(?:LOCAL:(\d+):([IO])\.DATA|([IO]):(\d+))$")
_WORD_AND_BIT = re.compile(r"\[(\d+)\]\.(\d+)$")
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

COMMAND_WORDS = 2
"""Words with command bits: MSW and LSW."""


class Use(NamedTuple):
    """A use of bits in a word of a 3601."""

    place: FileLine
    image: str  # "I", "O", or "" for a configuration
    word: int
    bits: int
    text: str  # the program's name for the bits


def replaced(subject: Subject, model: Model) -> Iterator[Violation]:
    """Yield the uses of 3601 words that have a different meaning on a drive, in line order."""
    rows = list(differences(model))
    texts: dict[tuple[FileLine, str], str] = {}  # by line and row of differences: one finding each
    for use in sorted(_uses(subject), key=lambda use: use[:-1]):
        if not use.image:
            texts.setdefault((use.place, ""), _sentence(use.text, *CONFIGURATION, model))
        for row in rows:
            if row.place == (use.image, use.word) and row.bits & use.bits:
                texts.setdefault((use.place, row.id), _text_of_row(row, use, model))
    yield from (Violation(place, text) for (place, _), text in texts.items())


def _text_of_row(row: Difference, use: Use, model: Model) -> str:
    bit_names = row.names(use.bits)
    text = use.text if bit_names in use.text else f"{use.text} ({bit_names})"
    return _sentence(text, row.on_3601, row.on_drive, row.write, f"{row.id}, {row.source}", model)


def _sentence(text: str, on_3601: str, on_drive: str, write: str, source: str, model: Model) -> str:
    return f"{text}: on a 3601 {on_3601}; on the {model.title} {on_drive}. Write instead: {write} [{source}]"


def _uses(subject: Subject) -> Iterator[Use]:
    """Yield the uses of bits and words: by tags, constants, configurations, commands and Python names."""
    slots = {slot.number for _, slot in subject.steppers}
    facts = subject.facts
    yield from _tag_uses(facts, slots)
    yield from _word_uses(facts, slots)
    for configuration in facts.configurations:
        if configuration.slot is None or configuration.slot in slots:
            yield Use(configuration.place, "", word=0, bits=0, text="configuration")
    for command in facts.commands:
        if command.words and command.text in _COMMANDS:
            yield Use(command.place, "O", 0, _COMMANDS[command.text].value, command.text)
    if subject.job.program.suffix == ".py" and not isinstance(subject.job.logic, LadderLogic):
        yield from _python_uses(subject, slots)


def _tag_uses(facts: Facts, slots: set[int]) -> Iterator[Use]:
    """Yield the uses of image bits by address, bit name or alias."""
    for access in facts.accesses:
        image, position = _IMAGE.match(access.variable), _WORD_AND_BIT.match(access.part)
        if image is None or position is None:
            continue
        side, slot = (image[2], image[1]) if image[1] else (image[3], image[4])
        # clearing an output bit has the same effect on a drive
        acts = side == "I" or access.use is not Touch.UNLATCH
        if acts and int(slot) in slots:
            word, bit = map(int, position.groups())
            yield Use(access.place, side, word, 1 << bit, access.text or access.variable)


def _word_uses(facts: Facts, slots: set[int]) -> Iterator[Use]:
    """Yield constants that are written to command words."""
    configures = {write.place for write in facts.writes if write.word == 0 and write.sets & MODE_CONFIG}
    for write in facts.writes:
        if write.slot in slots and write.word < COMMAND_WORDS and write.place not in configures:
            text = write.text or f"output word {write.word}"
            for option in write.options:
                yield Use(write.place, "O", write.word, option & UNSIGNED_MAX, text)


def _python_uses(subject: Subject, slots: set[int]) -> Iterator[Use]:
    """Yield bits that a Python program names: `StatusMsw.STOPPED`, `axis.status.STOPPED`, `.bit(0, 3)`."""
    file = str(subject.job.program)
    tree = ast.parse(read_input_text(subject.job.program, TextKind.PYTHON))
    images = Images(Reader(file, tree, {}, Facts()), subject.job.spec)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            owner = ast.unparse(node.value).rpartition(".")[2]
            for name, (image, word, bits) in _ENUMS.items():
                is_owner = owner == name or (owner == "status" and image == "I")
                if is_owner and node.attr in bits.__members__:
                    mask = bits[node.attr].value
                    yield Use(FileLine(file, node.lineno), image, word, mask, ast.unparse(node))
    yield from _image_bit_uses(file, tree, images, slots)


def _image_bit_uses(file: str, tree: ast.Module, images: Images, slots: set[int]) -> Iterator[Use]:
    """Yield the bits that a Python program reads or writes by number, such as `inputs.bit(0, 3)`."""
    for function in nodes_in(tree, ast.FunctionDef):
        local = images.locals_of(function)
        for node in ast.walk(function):
            match node:
                case ast.Call(
                    func=ast.Attribute(value=owner, attr="bit" | "set_bit"),
                    args=[ast.Constant(value=int(word)), ast.Constant(value=int(bit)), *_],
                ):
                    kind, slot = images.kind_of(owner, local)
                    if kind in ("inputs", "outputs") and (slot is None or slot in slots):
                        place, side = FileLine(file, node.lineno), kind[0].upper()
                        yield Use(place, side, word, 1 << bit, ast.unparse(node))
