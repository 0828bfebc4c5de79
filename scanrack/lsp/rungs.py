"""Instructions and declarations at a position in rungs or structured text.

The text need not be a valid program, since the user is still typing it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest

from scanrack.ladder.files.rungreader import LIBRARIES, load_library
from scanrack.ladder.lowering.addon import AddOn, ParameterMode
from scanrack.ladder.lowering.dialects import DIALECTS, LOGIX
from scanrack.ladder.model.predefined.structures import PREDEFINED_TYPES
from scanrack.ladder.model.spec import InstructionKind, Spec, Use
from scanrack.ladder.model.types import Structure

_WORD = re.compile(r"[A-Za-z_\\][\w:\\]*(?:\[[^\]]*\])?(?:\.\w+(?:\[[^\]]*\])?)*+")
_DECLARATION = re.compile(
    r"^\s*(?P<keyword>TAG|ALIAS|SLOT|Input|Output|InOut|Local)\s+(?P<name>[\w:]+)\s*:\s*(?P<type>[^:=/\s]*)"
    r"|^\s*(?P<block>ROUTINE|PROGRAM|CONTROLLER|INSTRUCTION|TYPE|TASK)\s+(?P<block_name>\w+)",
    re.IGNORECASE,
)
_DIALECT = re.compile(rf"^\s*DIALECT\s+({'|'.join(DIALECTS)})\b", re.IGNORECASE | re.MULTILINE)
_KINDS = {
    InstructionKind.INPUT: "decides whether the rung stays true",
    InstructionKind.OUTPUT: "acts on a true rung",
    InstructionKind.BOTH: "acts on a true and on a false rung",
}


@dataclass(frozen=True, slots=True)
class Offer:
    """One entry of a completion list."""

    name: str
    kind: str  # "instruction", "tag", "member", "routine", "key" or "value"
    detail: str = ""
    text: str = ""  # its description


@dataclass(frozen=True, slots=True)
class DeclarationLine:
    """A declaration in a text."""

    name: str
    keyword: str  # its first word, such as TAG
    type: str  # of a tag; "" for other declarations
    line: int  # from 0
    text: str  # the line
    comment: str


def declarations(text: str) -> Iterator[DeclarationLine]:
    """Yield the declarations of a text, in order."""
    for number, line in enumerate(text.splitlines()):
        code, _, comment = line.partition("//")
        match = _DECLARATION.match(code)
        if match:
            name, keyword = match["name"] or match["block_name"], match["keyword"] or match["block"]
            yield DeclarationLine(
                name,
                keyword=keyword.upper(),
                type=match["type"] or "",
                line=number,
                text=code.strip(),
                comment=comment.strip(),
            )


def word_at(line: str, column: int) -> str:
    """Return the address or name at a column, up to the member at the column; "" if there is none.

    >>> word_at("XIC(Fill.DN)OTE(Run);", 10), word_at("XIC(Fill.DN)OTE(Run);", 5), word_at("XIC(Run)", 1)
    ('Fill.DN', 'Fill', 'XIC')
    """
    for match in _WORD.finditer(line):
        if match.start() <= column <= match.end():
            tail = re.match(r"\w*", line[column : match.end()])
            return line[match.start() : column] + (tail[0] if tail else "")
    return ""


def declared_at(text: str, word: str) -> DeclarationLine | None:
    """Return the declaration of a name, or of the tag in an address; None if the text has none."""
    base = re.split(r"[.\[]", word.rpartition("\\")[2] if "\\" in word else word, maxsplit=1)[0].upper()
    return next((declaration for declaration in declarations(text) if declaration.name.upper() == base), None)


def meaning(text: str, line: str, column: int) -> str:
    """Return a description of the word at a position, in Markdown; "" if it is unknown."""
    word = word_at(line, column)
    spec = _instructions(text).get(word.upper())
    if spec is not None:
        return instruction_text(spec)
    declared = declared_at(text, word) if word else None
    if declared is None:
        block = next((candidate for candidate in _blocks() if candidate.name.upper() == word.upper()), None)
        return "" if block is None else block_text(block)
    member = _member_text(declared.type, word)
    lines = [f"```rung\n{declared.text}\n```", declared.comment, member]
    uses = [number for number, code in enumerate(text.splitlines(), 1) if _names(code, declared.name)]
    lines.append(f"in lines {', '.join(map(str, uses[:20]))}{', ...' if len(uses) > 20 else ''}")
    return "\n\n".join(filter(None, lines))


def _instructions(text: str) -> Mapping[str, Spec]:
    """Return the instructions of the dialect of a text."""
    match = _DIALECT.search(text)
    return DIALECTS[match[1].lower() if match else LOGIX]


def _blocks(text: str | None = None) -> Iterator[AddOn]:
    """Yield the blocks that come with scanrack, or only the blocks in the libraries that a text uses."""
    for name in LIBRARIES:
        if text is None or re.search(rf"^\s*USE\s+{name}\b", text, re.IGNORECASE | re.MULTILINE):
            yield from load_library(name).add_ons.values()


def _names(line: str, name: str) -> bool:
    return re.search(rf"(?<![\w.]){re.escape(name)}\b", line.partition("//")[0], re.IGNORECASE) is not None


def _member_text(type_name: str, word: str) -> str:
    _, dot, member = word.partition(".")
    return f"member {member} of {type_name}" if dot and type_name else ""


def signature(spec: Spec) -> str:
    """Return an instruction with the names of its operands.

    >>> signature(DIALECTS[LOGIX]["TON"]), signature(DIALECTS[LOGIX]["XIC"])
    ('TON(Timer, Preset, Accum)', 'XIC(bit)')
    """
    captions = zip_longest(spec.captions[: len(spec.operands)], spec.operands)
    names = [caption or _plain(use) for caption, use in captions]
    return f"{spec.name}({', '.join(names)})"


def _plain(use: Use) -> str:
    return use.name.lower().replace("_", " ")


def instruction_text(spec: Spec) -> str:
    """Return the description of an instruction in Markdown: operands, when it acts, and other name."""
    lines = [f"```rung\n{signature(spec)}\n```", f"{spec.name} {_KINDS[spec.kind]}."]
    if spec.decides:
        lines[1] = f"{spec.name} acts on a true and on a false rung, and decides the condition after it."
    if spec.other:
        lines.append(f"Since revision 36, Studio 5000 prints it as {spec.other}.")
    if spec.optional:
        lines.append(f"The last {spec.optional} operands may be left out.")
    if not spec.in_rungs:
        lines.append("Only for structured text.")
    elif spec.instead:
        lines.append(f"In structured text: {spec.instead}.")
    return "\n\n".join(lines)


def block_signature(block: AddOn) -> str:
    """Return the name of a block that comes with scanrack, followed by the names of its operands.

    >>> block_signature(load_library("axis3601").add_ons["MC_HALT"])
    'MC_Halt(instance, Axis, Execute)'
    """
    return f"{block.name}({', '.join(['instance', *(parameter.name for parameter in block.required)])})"


def block_text(block: AddOn) -> str:
    """Return the description of a block in Markdown: its operands, function, and parameters."""
    lines = []
    for parameter in block.parameters:
        if parameter.mode is not ParameterMode.LOCAL:
            comment = f"  // {parameter.comment}" if parameter.comment else ""
            lines.append(f"{parameter.mode.value} {parameter.name} : {parameter.type.name}{comment}")
    parameters = "\n".join(lines)
    return f"```rung\n{block_signature(block)}\n```\n\n{block.comment}\n\n```rung\n{parameters}\n```"


def _members(type_name: str) -> list[Offer]:
    """Return the members of a type or block that comes with scanrack; `type_name` is in capitals."""
    blocks = {block.name.upper(): block for block in _blocks()}
    if type_name in blocks:
        reached = (ParameterMode.INPUT, ParameterMode.OUTPUT)
        parameters = [parameter for parameter in blocks[type_name].parameters if parameter.mode in reached]
        return [
            Offer(parameter.name, "member", parameter.type.name, parameter.comment)
            for parameter in parameters
        ]
    types = {name: kind for library in LIBRARIES for name, kind in load_library(library).types.items()}
    kind = {**types, **PREDEFINED_TYPES}.get(type_name)
    members = kind.members if isinstance(kind, Structure) else ()
    return [Offer(member.name, "member", member.type.name) for member in members]


def _usable(text: str, *, structured: bool) -> Iterator[Spec]:
    """Yield the instructions that rungs or structured text can contain, without duplicates."""
    for instruction in {spec.name: spec for spec in _instructions(text).values()}.values():
        is_usable = (not instruction.instead) if structured else instruction.in_rungs
        if is_usable:
            yield instruction


def offers(text: str, line_start: str, *, structured: bool) -> list[Offer]:
    """Return the completions at a position in rungs or structured text.

    Args:
        line_start: the line up to the position.
        structured: whether it is structured text.
    """
    member = re.search(r"([\w:\\]+(?:\[[^\]]*\])?)\.\w*$", line_start)
    if member:
        declared = declared_at(text, member[1])
        return _members(declared.type.partition("[")[0].upper()) if declared else []
    declared_names = [
        Offer(
            declaration.name,
            "tag" if declaration.type or declaration.keyword == "SLOT" else "routine",
            declaration.type,
            declaration.comment,
        )
        for declaration in declarations(text)
        if declaration.keyword not in ("PROGRAM", "CONTROLLER", "TASK", "TYPE")
    ]
    specs = _usable(text, structured=structured)
    instructions = (
        Offer(spec.name, "instruction", signature(spec), instruction_text(spec)) for spec in specs
    )
    blocks = (
        Offer(block.name, "instruction", block_signature(block), block_text(block)) for block in _blocks(text)
    )
    return [*declared_names, *instructions, *blocks]
