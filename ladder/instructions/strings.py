"""String instructions, and conversions between strings and numbers.

A string is LEN and DATA. Minor faults leave the destination unchanged, except 4/51 with a long result:

| code | fault |
|---|---|
| 4/51 | LEN is above the size of DATA; the result is longer than the destination and is cut off |
| 4/52 | the string of a number is longer than the destination |
| 4/53 | the number in a string does not fit its destination |
| 4/56 | a start or a quantity is not inside of the string |
"""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import Decimal

from ..interpreter import Interpreter
from ..model import arithmetic
from ..model.errors import SHORT_STRING_CODE, STRING_CODE, STRING_NUMBER_CODE, STRING_PLACE_CODE
from ..model.operands import Group, Place, Resolved, StringConstant, width_of
from ..model.spec import Spec, Use, action
from ..state.regions import converted

_WHOLE = re.compile(rb"-?\d+")
_DECIMAL = re.compile(rb"-?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def _room(operand: Group) -> int:
    return operand.layout.leaf(f"{operand.path}.DATA").dims[-1]


def _read(machine: Interpreter, operand: Resolved) -> bytes | None:
    """Return the characters of a string; fault and return None if LEN exceeds the size of DATA."""
    if not isinstance(operand, StringConstant):
        assert isinstance(operand, Group)
        length, room = machine.get(operand.member("LEN")), _room(operand)
        if length > room:
            text = f"LEN of {operand.text} is {length}, DATA has {room} characters"
            machine.fault_log.record(machine.site, text, STRING_CODE)
            return None
    return machine.text(operand)


def _read_both(machine: Interpreter, a: Resolved, b: Resolved) -> tuple[bytes, bytes] | None:
    first, second = _read(machine, a), _read(machine, b)
    return None if first is None or second is None else (first, second)


def _store(machine: Interpreter, target: Group, value: bytes, code: int = STRING_CODE) -> None:
    if len(value) > _room(target):
        text = f"{len(value)} characters do not fit {target.text}, {_room(target)} do"
        machine.fault_log.record(machine.site, text, code)
        if code == SHORT_STRING_CODE:
            return
    machine.set_text(target, value)


def _misplaced(machine: Interpreter, text: str) -> None:
    machine.fault_log.record(machine.site, text, STRING_PLACE_CODE)


# --- CONCAT, INSERT: one string with another


def _concat(machine: Interpreter, a: Resolved, b: Resolved, target: Group) -> None:
    both = _read_both(machine, a, b)
    if both is not None:
        _store(machine, target, both[0] + both[1])


def _insert(machine: Interpreter, a: Resolved, b: Resolved, start: Resolved, target: Group) -> None:
    both, at = _read_both(machine, a, b), machine.integer(start)
    if both is None:
        return
    into, inserted = both
    if not 1 <= at <= len(into) + 1:
        _misplaced(machine, f"start {at} is out of range, allowed are 1 to {len(into) + 1}")
        return
    _store(machine, target, into[: at - 1] + inserted + into[at - 1 :])


# --- MID, DELETE: a part of a string


def _part(machine: Interpreter, source: Resolved, quantity: Resolved, start: Resolved) -> slice | None:
    """Return the start of a part; fault and return None if it is outside of the string."""
    text, count, at = _read(machine, source), machine.integer(quantity), machine.integer(start)
    if text is None:
        return None
    if not 1 <= at <= len(text) or count < 0 or at - 1 + count > len(text):
        _misplaced(machine, f"{count} characters from {at} on are not inside of {len(text)} characters")
        return None
    return slice(at - 1, at - 1 + count)


def _mid(machine: Interpreter, source: Resolved, quantity: Resolved, start: Resolved, target: Group) -> None:
    part = _part(machine, source, quantity, start)
    if part is not None:
        _store(machine, target, machine.text(source)[part])


def _delete(
    machine: Interpreter, source: Resolved, quantity: Resolved, start: Resolved, target: Group
) -> None:
    part = _part(machine, source, quantity, start)
    if part is not None:
        text = machine.text(source)
        _store(machine, target, text[: part.start] + text[part.stop :])


# --- FIND: where a string lies in another, 0 if it does not


def _find(machine: Interpreter, source: Resolved, search: Resolved, start: Resolved, result: Place) -> None:
    both, at = _read_both(machine, source, search), machine.integer(start)
    if both is None:
        return
    text, wanted = both
    if not 1 <= at <= len(text):
        _misplaced(machine, f"start {at} is out of range, allowed are 1 to {len(text)}")
        return
    machine.put(result, converted(result.type, text.find(wanted, at - 1) + 1))


# --- STOD, STOR: the first number in a string


def _number_in(pattern: re.Pattern[bytes]) -> Callable[[Interpreter, Resolved, Place], None]:
    def run(machine: Interpreter, source: Resolved, target: Place) -> None:
        text = _read(machine, source)
        if text is None:
            return
        found = pattern.search(text)
        if not text:
            return  # an empty string leaves the destination alone
        machine.clear_flags()
        if machine.lowered.flags:
            machine.set_status("S:C", True)
        _store_number(machine, Decimal(found.group().decode()) if found else Decimal(0), target)

    return run


def _store_number(machine: Interpreter, value: Decimal, target: Place) -> None:
    kind = target.type
    if not kind.is_integer:
        stored = converted(kind, float(value))
        fits = arithmetic.finite(stored)
    else:
        stored = converted(kind, int(value))
        fits = stored == int(value)
    if not fits:
        text = f"{value} does not fit {target.text}"
        machine.fault_log.record(machine.site, text, STRING_NUMBER_CODE)
    machine.put(target, stored)
    machine.set_flags(stored)


# --- DTOS, RTOS: a number as a string


def _dtos(machine: Interpreter, source: Resolved, target: Group) -> None:
    value = machine.number(source, width_of(source))
    whole = arithmetic.whole(value) if isinstance(value, float) else int(value)
    _store(machine, target, str(whole).encode(), SHORT_STRING_CODE)


def _rtos(machine: Interpreter, source: Resolved, target: Group) -> None:
    _store(machine, target, real_text(float(machine.number(source, 0))).encode(), SHORT_STRING_CODE)


def real_text(value: float) -> str:
    """Return a REAL with up to nine digits, which identify it; infinity is `1.$`.

    >>> [real_text(arithmetic.real(value)) for value in (15.3001, 0.5, -2.0, 1e20, 1e39)]
    ['15.3001003', '0.5', '-2.0', '1.00000002e+20', '1.$']
    """
    if value != value:
        return "1.#QNAN"
    if not arithmetic.finite(value):
        return "1.$" if value > 0 else "-1.$"
    text = f"{value:.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


# --- UPPER, LOWER


def _recased(name: str, change: Callable[[bytes], bytes]) -> Spec:
    def run(machine: Interpreter, source: Resolved, target: Group) -> None:
        text = _read(machine, source)
        if text is not None:
            _store(machine, target, change(text))

    return action(name, Use.TEXT, Use.TEXT_TARGET, run=run)


# --- the rows

CONCAT = action("CONCAT", Use.TEXT, Use.TEXT, Use.TEXT_TARGET, run=_concat)
DELETE = action("DELETE", Use.TEXT, Use.INTEGER, Use.INTEGER, Use.TEXT_TARGET, run=_delete)
FIND = action("FIND", Use.TEXT, Use.TEXT, Use.INTEGER, Use.INTEGER_TARGET, run=_find)
INSERT = action("INSERT", Use.TEXT, Use.TEXT, Use.INTEGER, Use.TEXT_TARGET, run=_insert)
MID = action("MID", Use.TEXT, Use.INTEGER, Use.INTEGER, Use.TEXT_TARGET, run=_mid)
STOD = action("STOD", Use.TEXT, Use.TARGET, run=_number_in(_WHOLE))
STOR = action("STOR", Use.TEXT, Use.TARGET, run=_number_in(_DECIMAL))
DTOS = action("DTOS", Use.NUMBER, Use.TEXT_TARGET, run=_dtos)
RTOS = action("RTOS", Use.NUMBER, Use.TEXT_TARGET, run=_rtos)
UPPER = _recased("UPPER", bytes.upper)
LOWER = _recased("LOWER", bytes.lower)
