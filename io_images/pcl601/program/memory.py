"""Program memory: the bytes of a program and the program of the bytes.

    byte 0    opcode: the row of the instruction table, from 1
    byte 1    ON, CW = 1; OFF, CCW = 0; the length of a text; otherwise 0
    then      the values, most significant byte first; a label as the address of its LABEL

Real opcodes are not published: this layout has the sizes of the instruction
table and is this simulator's own. Names of labels, comments and directives are
not stored; labels come back as L1, L2, ... in the order of their addresses.
"""

from __future__ import annotations

from itertools import accumulate

from .instructions import CAPACITY_BYTES, INSTRUCTIONS, Instruction
from .model import Program, ProgramError, Step, Value
from .operands import Choice, Label, Number
from .structure import check_structure

_OPCODES = {row.name: opcode for opcode, row in enumerate(INSTRUCTIONS, 1)}


def assemble(program: Program) -> bytes:
    """Return the bytes of a program.

    Raises:
        ProgramError: the program as a whole can't be stored, see `check_structure`.
    """
    check_structure(program)
    addresses = [0, *accumulate(step.size for step in program.steps)]
    places = {name: addresses[index] for name, index in program.labels.items()}
    return b"".join(_encoded(step, places) for step in program.steps)


def _encoded(step: Step, places: dict[str, int]) -> bytes:
    opcode = _OPCODES[step.name]
    if step.name == "TEXT":
        text = str(step.values[0]).encode("ascii")
        return bytes([opcode, len(text)]) + text
    second = 0
    body = b""
    for operand, value in zip(step.instruction.operands, step.values, strict=True):
        if isinstance(operand, Choice):
            second = int(value)
        elif isinstance(operand, Label):
            body += places[str(value)].to_bytes(operand.width) if operand.width else b""
        else:
            body += int(value).to_bytes(operand.width, signed=isinstance(operand, Number) and operand.low < 0)
    return bytes([opcode, second]) + body


def disassemble(memory: bytes) -> Program:
    """Return the program that stands in memory.

    Raises:
        ProgramError: there is more than memory holds, an opcode that is none, a value that is cut off
            or out of range, a jump to what is no label, or no END.
    """
    if len(memory) > CAPACITY_BYTES:
        raise ProgramError(f"{len(memory)} bytes are too many: program memory holds {CAPACITY_BYTES}")
    found: dict[int, Step] = {}
    address = 0
    while address < len(memory):
        step, size = _decoded(memory, address)
        found[address] = step
        address += size
    program = Program(tuple(_named(found)))
    check_structure(program)
    return program


def _decoded(memory: bytes, address: int) -> tuple[Step, int]:
    """Return the step at an address, labels still being addresses, and its size."""
    opcode = memory[address]
    if not 1 <= opcode <= len(INSTRUCTIONS):
        raise ProgramError(f"address {address}: {opcode:#04x} is no instruction")
    row = INSTRUCTIONS[opcode - 1]
    size = row.size + (memory[address + 1] if row.name == "TEXT" and address + 1 < len(memory) else 0)
    field = memory[address : address + size]
    if len(field) < size:
        raise ProgramError(f"address {address}: {row.name} takes {size} bytes, there are {len(field)}")
    values = _text(field, address) if row.name == "TEXT" else _values(row, field, address)
    return Step(row.name, values), size


def _text(field: bytes, address: int) -> tuple[Value, ...]:
    if not field[2:].isascii():
        raise ProgramError(f"address {address}: text is ASCII")
    return (field[2:].decode("ascii"),)


def _values(row: Instruction, field: bytes, address: int) -> tuple[Value, ...]:
    values: list[Value] = []
    at = 2
    for operand in row.operands:
        raw = field[at : at + operand.width]
        at += operand.width
        if isinstance(operand, Choice):
            values.append(field[1] & 1)
        elif isinstance(operand, Label):
            values.append(str(int.from_bytes(raw)) if operand.width else str(address))
        else:
            values.append(_number(operand, raw, address))
    return tuple(values)


def _number(operand: object, raw: bytes, address: int) -> int:
    value = int.from_bytes(raw, signed=isinstance(operand, Number) and operand.low < 0)
    if isinstance(operand, Number) and not operand.low <= value <= operand.high:
        raise ProgramError(
            f"address {address}: {value} is out of range: {operand.name} is {operand.low} to {operand.high}"
        )
    return value


def _named(found: dict[int, Step]) -> list[Step]:
    """Give the labels names instead of addresses."""
    labels = [address for address, step in found.items() if step.name == "LABEL"]
    names = {str(address): f"L{number}" for number, address in enumerate(labels, 1)}
    return [_renamed(step, names) for step in found.values()]


def _renamed(step: Step, names: dict[str, str]) -> Step:
    if step.name != "LABEL" and step.target is None:
        return step
    label = str(step.values[-1])
    return Step(step.name, (*step.values[:-1], names.get(label, f"at address {label}")))
