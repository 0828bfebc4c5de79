"""Describes current block states in words: `moving to 6,000` instead of a box of parameters.

A block has a row for each state. The condition of a row is a BOOL or `POWER`, and the page shows the first
row whose condition is on. `.ACC` is a member of the first operand, `Axis.Position` is a member of the
operand captioned Axis, and `2` is the third operand. A row with a missing reference is omitted.
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
    """A block's state: its condition ("" means always) and up to two lines. A number is on if it is not 0.

    A value replaces `{Position}`; a value in ms, shown in seconds, replaces `{.ACC:s}`. If the
    instruction has a time base, as in an SLC 500, the page uses `{.ACC:s10}` for a value in units of 10 ms.
    """

    condition: str
    line: str
    second_line: str = ""


_ERROR, _IDLE = BlockState(".Error", "error {.ErrorID}"), BlockState("", "idle")
_TO, _AT = "at {Axis.Position}, {Velocity} steps/s", "at {Axis.Position}"
_TIMER = (BlockState("", "{.ACC:s} of {.PRE:s} s"),)
_COUNTER = BlockState(".PRE", "{.ACC} of {.PRE}"), BlockState("", "{.ACC}, preset 0")


def _block(busy: str, done: str, second: str = "", *extra: BlockState) -> tuple[BlockState, ...]:
    return _ERROR, *extra, BlockState(".Busy", busy, second), BlockState(".Done", done), _IDLE


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
    "CLR": _with_power("clears"),
    **dict.fromkeys(("COP", "CPS"), _with_power("copies, length {2}")),
    "FLL": _with_power("fills with {0}"),
    "CPT": _with_power("result {0}"),
    **dict.fromkeys(
        ("SQR", "NEG", "ABS", "TRN", "NOT", "DEG", "RAD", "TOD", "FRD"), _with_power("result {1}")
    ),
    **dict.fromkeys(("SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG"), _with_power("result {1}")),
    **dict.fromkeys(("ADD", "SUB", "MUL", "DIV", "MOD", "AND", "OR", "XOR"), _with_power("result {2}")),
    **dict.fromkeys(("XPY", "ATAN2", "MVM", "SWPB"), _with_power("result {2}")),
    "SCP": _with_power("result {5}"),
    **dict.fromkeys(("FAL", "FSC"), _control(0)),
    **dict.fromkeys(("SRT", "FFL", "FFU", "LFL", "LFU", "SQL"), _control(2)),
    **dict.fromkeys(("AVE", "STD", "SQI", "SQO"), _control(3)),
}
"""States of instructions that still show their operands; the text appears beside the title."""

STATES: Mapping[str, tuple[BlockState, ...]] = {
    "Amci3601": (
        BlockState("Axis.LinkDown", "module not responding"),
        BlockState("Axis.ErrorStop", "error {Axis.ErrorID}", _AT),
        BlockState("Axis.Moving", "axis moving", _AT),
        BlockState("", "axis at rest", _AT),
    ),
    "Configure3601": _block("configuring", "configured"),
    "MC_MoveAbsolute": _block("moving to {Position}", "at {Position}", _TO),
    "MC_MoveRelative": _block("moving by {Distance}", "moved", _TO),
    "MC_MoveVelocity": _block(
        "changing to {Velocity}", "done", _AT, BlockState(".InVelocity", "running at {Velocity} steps/s", _AT)
    ),
    "MC_Home": _block("homing", "at home", _TO),
    "MC_Halt": _block("braking", "stopped", _AT),
    "MC_Stop": _block("stopping, holding the axis", "holding the axis", _AT),
    "MC_Reset": _block("resetting errors", "errors reset"),
    "MC_SetPosition": _block("setting {Position}", "set to {Position}"),
    "MC_GearIn": _block("gearing in", "done", _AT, BlockState(".InGear", "following the encoder", _AT)),
    "MAM": _motion("moving: {3} at {4}", "complete"),
    "MAJ": _motion("jogging at {3}", "complete"),
    "MAH": _motion("homing", "at home"),
}
"""States of blocks by instruction; the text replaces the operands."""

_OF_OTHER_ADD_ONS = BlockState(".Error", "error"), *_block("busy", "done")[1:]
"""States for any other add-on instruction that has these outputs."""

TIME_BASE = "Time base"
"""Caption of the operand with the time base of an SLC 500's timer, in seconds."""

WIDE = 26
"""Columns reserved for a line of state text."""

_REFERENCE = re.compile(r"\{([^}]+?)(:s\d*)?\}")


class BlockTexts(NamedTuple):
    """The states of a block, with a program's tag names; a value replaces `{Out.ACC}`."""

    states: tuple[BlockState, ...]

    @property
    def lines(self) -> int:
        """Number of lines."""
        return 1 + any(state.second_line for state in self.states)

    def line(self, number: int) -> list[tuple[str, str]]:
        """Return the conditions and texts of line 0 or 1."""
        return [(state.condition, state.second_line if number else state.line) for state in self.states]

    def names(self) -> tuple[str, ...]:
        """Return the tags used in conditions and lines."""
        names = [state.condition for state in self.states if state.condition not in ("", POWER)]
        for state in self.states:
            for text in (state.line, state.second_line):
                names += [match[1] for match in _REFERENCE.finditer(text)]
        return tuple(dict.fromkeys(names))


def states_of(instruction: Instruction, captions: Sequence[str], name_of: TagName) -> BlockTexts | None:
    """Return the states of an instruction; None for an instruction without states."""
    default_states = _OF_OTHER_ADD_ONS if captions[:1] == ("Instance",) else ()
    states = BESIDE.get(instruction.name) or STATES.get(instruction.name, default_states)
    reader = _TagReader(instruction.operands, captions, name_of)
    named_states = tuple(filter(None, map(reader.named, states)))
    shows_state = any(state.condition or _REFERENCE.search(state.line) for state in named_states)
    return BlockTexts(named_states) if shows_state else None


class _TagReader(NamedTuple):
    """Reads references to the operands of an instruction."""

    operands: Sequence[Operand]
    captions: Sequence[str]
    name_of: TagName

    def named(self, state: BlockState) -> BlockState | None:
        """Return a state with tag names instead of references; None if a reference has no tag."""
        condition = state.condition
        try:
            if condition not in ("", POWER):
                condition = self._value(condition).strip("{}")
            return BlockState(condition, self._with_tags(state.line), self._with_tags(state.second_line))
        except LookupError:
            return None

    def _with_tags(self, text: str) -> str:
        return _REFERENCE.sub(lambda match: self._value(*match.groups("")), text)

    def _value(self, reference: str, unit: str = "") -> str:
        """Return a reference with a tag name, or a constant's text.

        Raises:
            LookupError: the instruction does not have that operand, or the operand does not have that tag.
        """
        stem, _, member = reference.partition(".")
        if stem.isdigit():
            operand = self.operands[int(stem)]
        elif not stem:
            operand = self.operands[0]
        elif stem in self.captions:
            operand = self.operands[self.captions.index(stem)]
        else:
            raise LookupError(reference)
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
