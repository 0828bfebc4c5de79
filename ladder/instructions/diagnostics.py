"""FBC, DDT and DTR: bit-by-bit comparisons [1756-RM003N, compare and sequencer diagnostics].

FBC and DDT search once each time the rung becomes true: for the next mismatch if IN of the compare CONTROL is
set, otherwise for all mismatches. A mismatch sets FD and appends its bit number to the result array. DDT also
copies the bit to the reference. A false rung resets a completed search, so that the next search begins at bit
0.
"""

from __future__ import annotations

from functools import partial

from ..compiler.edges import write_comparison
from ..interpreter import Interpreter
from ..interpreter.files import Control, Elements
from ..model.operands import Group, Place, Resolved
from ..model.spec import WITH_CONTROL, Spec, Use, always
from ..model.types import Elementary
from ..state.regions import converted


class _Bits:
    """The bits of an array, numbered from the operand's first bit."""

    def __init__(self, machine: Interpreter, operand: Resolved) -> None:
        self._elements = Elements(machine, operand)
        kind = self._elements.type
        assert isinstance(kind, Elementary)
        self._type, self._width = kind, kind.bits

    def __getitem__(self, number: int) -> bool:
        word, bit = divmod(number, self._width)
        return bool(int(self._elements[word]) >> bit & 1)

    def __setitem__(self, number: int, value: bool) -> None:
        word, bit = divmod(number, self._width)
        other_bits = int(self._elements[word]) & ~(1 << bit)
        self._elements[word] = converted(self._type, other_bits | value << bit)


def _compare(
    machine: Interpreter,
    power: bool,
    source: Resolved,
    reference: Resolved,
    result: Resolved,
    search_control: Group,
    result_control: Group,
    *,
    updates: bool,
) -> None:
    """Run FBC, or with `updates` DDT, which copies each mismatched bit to the reference.

    It searches once when the rung becomes true; a LEN of 0 or less or a POS below 0 sets ER instead. A
    false rung clears EN, ER and FD, and resets each CONTROL that is done.
    """
    search, results = Control(machine, search_control), Control(machine, result_control)
    if not power:
        search.set(EN=False, ER=False, FD=False)
        for control in (search, results):
            if control["DN"]:
                control.set(DN=False, POS=0)
        return
    if search["EN"]:
        return
    search.set(EN=True, FD=False)
    if any(group["LEN"] <= 0 or group["POS"] < 0 for group in (search, results)):
        search.set(ER=True)
        return
    source_bits, expected = _Bits(machine, source), _Bits(machine, reference)
    numbers = Elements(machine, result)
    while search["POS"] < search["LEN"]:
        bit = search["POS"]
        search.set(POS=bit + 1)
        if source_bits[bit] == expected[bit]:
            continue
        if updates:
            expected[bit] = source_bits[bit]
        _append_bit_number(results, numbers, bit)
        search.set(FD=True)
        if search["IN"]:
            break
    search.set(DN=search["POS"] >= search["LEN"])


def _append_bit_number(results: Control, numbers: Elements, bit: int) -> None:
    """Append a bit number to the result array; start over if the array is full."""
    position = 0 if results["POS"] >= results["LEN"] else results["POS"]
    kind = numbers.type
    assert isinstance(kind, Elementary)
    numbers[position] = converted(kind, bit)
    results.set(POS=position + 1, DN=position + 1 >= results["LEN"])


def _prescan(machine: Interpreter, *operands: Resolved) -> None:
    """Clear EN and DN of both CONTROL operands."""
    for operand in operands[3:]:
        assert isinstance(operand, Group)
        Control(machine, operand).set(EN=False, DN=False)


# --- DTR


def _dtr(machine: Interpreter, power: bool, source: Resolved, mask: Resolved, reference: Place) -> bool:
    """Store the masked source in the reference; return whether the rung is true and this changed it."""
    masked = machine.integer(source) & machine.integer(mask)
    changed = machine.integer(reference) != masked
    machine.put(reference, machine.converted(reference.type, masked))
    return power and changed


def _prescan_dtr(machine: Interpreter, source: Resolved, mask: Resolved, reference: Place) -> None:
    _dtr(machine, False, source, mask, reference)


# --- the rows

_FILES = (
    *(Use.TABLE, Use.ARRAY, Use.ARRAY),
    *WITH_CONTROL,
    *WITH_CONTROL,
)


def _row(name: str, *, updates: bool) -> Spec:
    run = partial(_compare, updates=updates)
    return always(name, *_FILES, run=run, write=write_comparison, partly=True, prescan=_prescan)


FBC = _row("FBC", updates=False)
DDT = _row("DDT", updates=True)
DTR = always(
    "DTR",
    Use.INTEGER,
    Use.INTEGER,
    Use.INTEGER_TARGET,
    run=_dtr,
    prescan=_prescan_dtr,
    decides=True,
    alone=True,
)
