"""Current states of blocks in words: `moving to 6,000` instead of a box of parameters.

A block has a row for each state. Its condition is a BOOL or `POWER`, and the first row whose condition is on
is shown. `.ACC` is a member of the first operand, `Axis.Position` is a member of the operand captioned Axis,
and `2` is the third operand. A row with a reference that the program does not have is omitted.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..model.tree import Address, Instruction, Operand
from .markup import TagName

POWER = "*"
"""Condition of a state: power reaches the block."""


class BlockState(NamedTuple):
    """A state of a block: its condition, "" for always, and up to two lines. A number counts as on if not 0.

    `{Position}` stands for a value, and `{.ACC:s}` for a value in ms that is shown in seconds. If the
    instruction has a time base, as in an SLC 500, the page gets `{.ACC:s10}`, for a value in units of 10 ms.
    """

    when: str
    line: str
    more: str = ""


_ERROR, _IDLE = BlockState(".Error", "error {.ErrorID}"), BlockState("", "idle")
_TO, _AT = "at {Axis.Position}, {Velocity} steps/s", "at {Axis.Position}"
_TIMER = (BlockState("", "{.ACC:s} of {.PRE:s} s"),)
_COUNTER = BlockState(".PRE", "{.ACC} of {.PRE}"), BlockState("", "{.ACC}, preset 0")


def _block(busy: str, done: str, more: str = "", *before: BlockState) -> tuple[BlockState, ...]:
    return _ERROR, *before, BlockState(".Busy", busy, more), BlockState(".Done", done), _IDLE


def _motion(busy: str, done: str) -> tuple[BlockState, ...]:
    return BlockState("1.ER", "error {1.ERR}"), BlockState("1.IP", busy), BlockState("1.PC", done), _IDLE


def _with_power(line: str) -> tuple[BlockState, ...]:
    return BlockState(POWER, line), _IDLE


def _control(operand: int) -> tuple[BlockState, ...]:
    return (BlockState("", f"{{{operand}.POS}} of {{{operand}.LEN}}"),)


BESIDE: Mapping[str, tuple[BlockState, ...]] = {
    **dict.fromkeys(("TON", "TOF", "RTO"), _TIMER),
    **dict.fromkeys(("CTU", "CTD"), _COUNTER),
    "MOV": _with_power("moves {0}"),
    "BTD": _with_power("moves {4} bits"),
    "CLR": _with_power("clears it"),
    **dict.fromkeys(("COP", "CPS"), _with_power("copies, length {2}")),
    "FLL": _with_power("fills with {0}"),
    "CPT": _with_power("gives {0}"),
    **dict.fromkeys(
        ("SQR", "NEG", "ABS", "TRN", "NOT", "DEG", "RAD", "TOD", "FRD"), _with_power("gives {1}")
    ),
    **dict.fromkeys(("SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG"), _with_power("gives {1}")),
    **dict.fromkeys(("ADD", "SUB", "MUL", "DIV", "MOD", "AND", "OR", "XOR"), _with_power("gives {2}")),
    **dict.fromkeys(("XPY", "ATAN2", "MVM", "SWPB"), _with_power("gives {2}")),
    "SCP": _with_power("gives {5}"),
    **dict.fromkeys(("FAL", "FSC"), _control(0)),
    **dict.fromkeys(("SRT", "FFL", "FFU", "LFL", "LFU", "SQL"), _control(2)),
    **dict.fromkeys(("AVE", "STD", "SQI", "SQO"), _control(3)),
}
"""States of instructions that still show their operands; the text is beside the title."""

STATES: Mapping[str, tuple[BlockState, ...]] = {
    "Amci3601": (
        BlockState("Axis.LinkDown", "the module does not answer"),
        BlockState("Axis.ErrorStop", "error {Axis.ErrorID}", _AT),
        BlockState("Axis.Moving", "the axis moves", _AT),
        BlockState("", "the axis rests", _AT),
    ),
    "Configure3601": _block("configuring", "configured"),
    "MC_MoveAbsolute": _block("moving to {Position}", "is at {Position}", _TO),
    "MC_MoveRelative": _block("moving by {Distance}", "has moved", _TO),
    "MC_MoveVelocity": _block(
        "on the way to {Velocity}", "done", _AT, BlockState(".InVelocity", "runs at {Velocity} steps/s", _AT)
    ),
    "MC_Home": _block("homing", "is at home", _TO),
    "MC_Halt": _block("braking", "has come to rest", _AT),
    "MC_Stop": _block("stopping, holds the axis", "holds the axis", _AT),
    "MC_Reset": _block("resetting errors", "errors are reset"),
    "MC_SetPosition": _block("setting {Position}", "has set {Position}"),
    "MC_GearIn": _block("gearing in", "done", _AT, BlockState(".InGear", "follows the encoder", _AT)),
    "MAM": _motion("moving: {3} at {4}", "complete"),
    "MAJ": _motion("jogging at {3}", "complete"),
    "MAH": _motion("homing", "is at home"),
}
"""States of blocks by instruction; the text replaces the operands."""

_OTHERS = BlockState(".Error", "error"), *_block("busy", "done")[1:]
"""States of an add-on instruction that has these outputs."""

TIME_BASE = "Time base"
"""Caption of the operand with the time base of an SLC 500's timer, in seconds."""

WIDE = 26
"""Columns reserved for a line."""

_REFERENCE = re.compile(r"\{([^}]+?)(:s\d*)?\}")


class BlockTexts(NamedTuple):
    """The states of a block with a program's tag names: conditions and lines; `{Out.ACC}` is a value."""

    rows: tuple[tuple[str, str, str], ...]

    @property
    def lines(self) -> int:
        """Number of lines."""
        return 1 + any(second for _when, _line, second in self.rows)

    def line(self, number: int) -> list[tuple[str, str]]:
        """Return the conditions and texts of line 0 or 1."""
        return [(row[0], row[1 + number]) for row in self.rows]

    def names(self) -> tuple[str, ...]:
        """Return the tags in conditions and lines."""
        used = [
            reference[1] for row in self.rows for text in row[1:] for reference in _REFERENCE.finditer(text)
        ]
        return tuple(dict.fromkeys([*(row[0] for row in self.rows if row[0] not in ("", POWER)), *used]))


def states_of(instruction: Instruction, captions: Sequence[str], name_of: TagName) -> BlockTexts | None:
    """Return the states of an instruction; None if it has none."""
    others = _OTHERS if captions[:1] == ("Instance",) else ()
    states = BESIDE.get(instruction.name) or STATES.get(instruction.name, others)
    reader = _TagReader(instruction.operands, captions, name_of)
    rows = tuple(row for row in map(reader.row, states) if row is not None)
    return BlockTexts(rows) if any(when or _REFERENCE.search(line) for when, line, _more in rows) else None


class _TagReader(NamedTuple):
    """Reads references to the operands of an instruction."""

    operands: Sequence[Operand]
    captions: Sequence[str]
    name_of: TagName

    def row(self, state: BlockState) -> tuple[str, str, str] | None:
        """Return a state with tag names in place of references; None if the program lacks one."""
        try:
            known = state.when in ("", POWER)
            when = state.when if known else self._value(state.when).strip("{}")
            line, second = (
                _REFERENCE.sub(lambda each: self._value(*each.groups("")), text) for text in state[1:]
            )
        except LookupError:
            return None
        return when, line, second

    def _value(self, reference: str, unit: str = "") -> str:
        """Return a reference with a tag name, or a constant's text; LookupError if there is no operand."""
        stem, _, member = reference.partition(".")
        if stem and not stem.isdigit() and stem not in self.captions:
            raise LookupError(reference)
        operand = self.operands[int(stem) if stem.isdigit() else self.captions.index(stem) if stem else 0]
        if isinstance(operand, Address):
            name = self.name_of(operand.member(member) if member else operand)
            if name is not None:
                return f"{{{name}{unit and self._unit()}}}"
        elif not member:
            return _constant(operand)
        raise LookupError(reference)

    def _unit(self) -> str:
        if TIME_BASE not in self.captions:
            return ":s"
        base = self.operands[self.captions.index(TIME_BASE)]
        return f":s{round(1000 * float(str(base)))}"


def _constant(operand: Operand) -> str:
    text = str(operand)
    return f"{int(text):,}" if text.lstrip("-").isdigit() else text
