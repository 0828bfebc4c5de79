"""The interpreter: executes the linked tree plainly. It is slow, and it is what the compiler has to equal.

Power flows from left to right. An input that is reached with power decides whether
there is power behind it; an output that is reached acts. Every instruction is one
short method, in the words of the manual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import arithmetic as math
from .errors import LadderFault
from .instructions import BITWISE, RELATIONS, Kind
from .linked import ADD_ON, AddOnCall, Call, Line, Linked, LinkedRoutine, Node, Parallel, Step
from .memory import Memory, Value
from .places import Calculation, Constant, Group, Place, Quoted, Resolved, types_in
from .regions import copy, region_of
from .tags import OVERRIDE
from .trouble import Trouble
from .types import DINT, LINT, REAL

MS = 1_000_000
"""Nanoseconds of a millisecond."""

Caller = Callable[[str, Sequence[Value]], Sequence[Value]]
"""Calls a routine in Python: name in capitals, values in; returns the values out."""


class _Jump(Exception):  # noqa: N818 - control flow, not an error
    def __init__(self, label: str) -> None:
        self.label = label


class _Return(Exception):  # noqa: N818
    def __init__(self, values: tuple[Value, ...]) -> None:
        self.values = values


class Interpreter:
    """Runs a linked program on a memory.

    Args:
        linked: the program.
        memory: its memory.
        trouble: collects its faults.
        call_python: calls routines in Python.
    """

    def __init__(self, linked: Linked, memory: Memory, trouble: Trouble, call_python: Caller) -> None:
        self._linked, self._memory, self._trouble = linked, memory, trouble
        self._call_python = call_python
        self._site = 0
        self._now = 0

    # --- running

    def scan(self, now_ns: int) -> None:
        """Run the main routine once.

        Raises:
            LadderFault: a major fault.
        """
        self._now = now_ns
        if self._linked.override:
            self._set_leaf(OVERRIDE, False)
        self.run(self._linked.main, ())

    def run(self, name: str, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Run a routine; return what it returns."""
        if name in self._linked.functions:
            return tuple(self._call_python(name, inputs))
        routine = self._linked.routines[name]
        try:
            self._lines(routine, inputs)
        except _Return as back:
            return back.values
        return ()

    def _lines(self, routine: LinkedRoutine, inputs: Sequence[Value]) -> None:
        number = 0
        while number < len(routine.lines):
            try:
                self._line(routine.lines[number], inputs)
                number += 1
            except _Jump as jump:
                number = routine.labels[jump.label]

    def _line(self, line: Line, inputs: Sequence[Value]) -> None:
        power = not (self._linked.override and self._leaf(OVERRIDE))
        self._inputs = inputs
        self._series(line.nodes, power)

    def _series(self, nodes: tuple[Node, ...], power: bool) -> bool:
        for node in nodes:
            power = self._branch(node, power) if isinstance(node, Parallel) else self._step(node, power)
        return power

    def _branch(self, branch: Parallel, power: bool) -> bool:
        behind = [self._series(leg, power) for leg in branch.legs]
        return any(behind)

    def _step(self, step: Step, power: bool) -> bool:
        self._site = step.site
        if step.name == ADD_ON:
            return self._add_on(power, step.operands[0])
        if step.kind is Kind.BOTH:
            _BOTH[step.name](self, power, *step.operands)
            return power
        if step.name == "ONS":
            return self._one_shot(power, step.operands[0])
        if not power:
            return False
        if step.kind is Kind.INPUT:
            return _INPUTS[step.name](self, *step.operands)
        _OUTPUTS[step.name](self, *step.operands)
        return True

    def _add_on(self, power: bool, call: AddOnCall) -> bool:
        """Copy in, run the routine that the rung asks for, copy out [1756-PM010]."""
        for series in call.inputs:
            self._series(series, True)
        self.put(call.enable_in, power)
        self.put(call.enable_out, power)
        routine = call.logic if power else call.otherwise
        if routine is not None:
            inputs = self._inputs
            self.run(routine, ())
            self._inputs = inputs
        for series in call.outputs:
            self._series(series, True)
        return bool(self.get(call.enable_out))

    # --- memory

    def _leaf(self, path: str) -> Value:
        return self._memory.read(self._memory.layout.leaf(path))

    def _set_leaf(self, path: str, value: Value) -> None:
        self._memory.write(self._memory.layout.leaf(path), 0, value)

    def _index(self, place: Place) -> int:
        flat = 0
        for index, length in zip(place.indices, place.leaf.dims, strict=True):
            flat = flat * length + self._subscript(index, length, place.text)
        return flat

    def _subscript(self, index: Resolved, length: int, tag: str) -> int:
        value = self._integer(index)
        if not 0 <= value < length:
            self._trouble.subscript(self._site, tag, value, length)
        return value

    def get(self, place: Place) -> Value:
        """Return the value of a place."""
        value = self._memory.read(place.leaf, self._index(place))
        if place.bit is None:
            return value
        bit = self._subscript(place.bit, place.leaf.type.bits, place.text)
        return bool(int(value) >> bit & 1)

    def put(self, place: Place, value: Value) -> None:
        """Set a place to a value of its type."""
        index = self._index(place)
        if place.bit is not None:
            bits = place.leaf.type.bits
            mask = 1 << self._subscript(place.bit, bits, place.text)
            word = int(self._memory.read(place.leaf, index))
            value = math.wrap(word | mask if value else word & ~mask, bits)
        self._memory.write(place.leaf, index, value)

    def _integer(self, operand: Resolved) -> int:
        return int(self._number(operand, DINT.bits))

    # --- numbers

    def _number(self, operand: Resolved, width: int) -> Value:
        """Value of an expression, computed in integers of that width or, width 0, in REAL."""
        if isinstance(operand, Calculation):
            if not width and operand.name in BITWISE:
                return math.real(self._number(operand, width_of(operand)))
            values = [self._number(each, width) for each in operand.operands]
            return self._calculate(operand.name, values, width)
        value = operand.value if isinstance(operand, Constant) else self.get(_place(operand))
        return value if width else math.real(value)

    def _calculate(self, name: str, values: Sequence[Any], width: int) -> Value:
        if width == 0:
            return self._calculate_real(name, values)
        if name in ("/", "MOD") and values[1] == 0:
            self._trouble.zero_divisor(self._site)
            return values[0]  # type: ignore[no-any-return]
        exact = _WHOLE[name](*values)
        result = math.wrap(exact, width)
        if result != exact:
            self._trouble.overflow(self._site)
        return result

    def _calculate_real(self, name: str, values: Sequence[Any]) -> float:
        if name in ("/", "MOD") and values[1] == 0:
            self._trouble.zero_divisor(self._site)
        result: float = _REAL[name](*values)
        if not math.finite(result) and all(map(math.finite, values)):
            self._trouble.overflow(self._site)
        return result

    def _store(self, place: Place, value: Value) -> None:
        """Convert to the type of a place and set it."""
        kind = place.type
        if kind.is_bool:
            self.put(place, bool(value))
            return
        if kind.is_real:
            stored: Value = math.real(value)
        else:
            exact = math.whole(value) if isinstance(value, float) else int(value)
            stored = math.wrap(exact, kind.bits)
            if stored != exact or (isinstance(value, float) and not math.finite(value)):
                self._trouble.overflow(self._site)
        self.put(place, stored)
        self._after(stored)

    def _before(self) -> None:
        if self._linked.flags:
            self._set_leaf("S:V", False)
            self._set_leaf("S:C", False)

    def _after(self, stored: Value) -> None:
        if self._linked.flags:
            self._set_leaf("S:Z", stored == 0)
            self._set_leaf("S:N", stored < 0)

    def _compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        self._before()
        expression = Calculation(name, operands)
        width = width_of(expression, target)
        if self._linked.flags and width:
            self._set_leaf("S:C", self._carry(name, operands, width))
        self._store(target, self._number(expression, width))

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> bool:
        if name not in ("+", "-", "NEG"):
            return False
        mask = (1 << width) - 1
        values = [int(self._number(each, width)) & mask for each in operands]
        if name == "+":
            return values[0] + values[1] > mask
        return values[0] < values[1] if name == "-" else values[0] != 0

    # --- bit instructions

    def _one_shot(self, power: bool, storage: Place) -> bool:
        passes = power and not self.get(storage)
        self.put(storage, power)
        return passes

    def _xic(self, bit: Place) -> bool:
        return bool(self.get(bit))

    def _xio(self, bit: Place) -> bool:
        return not self.get(bit)

    def _ote(self, power: bool, bit: Place) -> None:
        self.put(bit, power)

    def _otl(self, bit: Place) -> None:
        self.put(bit, True)

    def _otu(self, bit: Place) -> None:
        self.put(bit, False)

    def _osr(self, power: bool, storage: Place, output: Place) -> None:
        before = self.get(storage)
        self.put(storage, power)
        self.put(output, power and not before)

    def _osf(self, power: bool, storage: Place, output: Place) -> None:
        before = self.get(storage)
        self.put(storage, power)
        self.put(output, bool(before) and not power)

    # --- timers and counters

    def _count_time(self, timer: Group) -> None:
        """Add the time since the last scan of the instruction, in whole ms; what is over waits."""
        last = timer.member("~last_ns")
        elapsed = (self._now - int(self.get(last))) // MS
        accumulated = timer.member("ACC")
        self.put(accumulated, min(int(self.get(accumulated)) + elapsed, DINT.highest))
        self.put(last, int(self.get(last)) + elapsed * MS)

    def _start_time(self, timer: Group) -> None:
        self.put(timer.member("~last_ns"), self._now)

    def _reached(self, timer: Group) -> bool:
        preset, accumulated = int(self.get(timer.member("PRE"))), int(self.get(timer.member("ACC")))
        if preset < 0 or accumulated < 0:
            self._trouble.negative_timer(self._site, timer.text, preset, accumulated)
        return accumulated >= preset

    def _set_bits(self, structure: Group, **bits: bool) -> None:
        for name, value in bits.items():
            self.put(structure.member(name), value)

    def _time_on(self, timer: Group) -> None:
        if self.get(timer.member("DN")):
            self._set_bits(timer, EN=True, TT=False)
            return
        if self.get(timer.member("EN")):
            self._count_time(timer)
        else:
            self._start_time(timer)
        done = self._reached(timer)
        self._set_bits(timer, EN=True, TT=not done, DN=done)

    def _ton(self, power: bool, timer: Group) -> None:
        if power:
            self._time_on(timer)
        else:
            self._set_bits(timer, EN=False, TT=False, DN=False)
            self.put(timer.member("ACC"), 0)

    def _rto(self, power: bool, timer: Group) -> None:
        if power:
            self._time_on(timer)
        else:
            self._set_bits(timer, EN=False, TT=False)

    def _tof(self, power: bool, timer: Group) -> None:
        if power:
            self._set_bits(timer, EN=True, TT=False, DN=True)
            self.put(timer.member("ACC"), 0)
        elif self.get(timer.member("DN")):
            if self.get(timer.member("EN")):
                self._start_time(timer)
            else:
                self._count_time(timer)
            done = self._reached(timer)
            self._set_bits(timer, EN=False, TT=not done, DN=not done)
        else:
            self._set_bits(timer, EN=False, TT=False)

    def _count(self, power: bool, counter: Group, enable: str, by: int) -> None:
        if not power:
            self.put(counter.member(enable), False)
            return
        if not self.get(counter.member(enable)):
            self.put(counter.member(enable), True)
            self._one_count(counter, by)
        over, under = self.get(counter.member("OV")), self.get(counter.member("UN"))
        reached = self.get(counter.member("ACC")) >= self.get(counter.member("PRE"))
        self.put(counter.member("DN"), bool(over or (reached and not under)))

    def _one_count(self, counter: Group, by: int) -> None:
        accumulated = counter.member("ACC")
        exact = int(self.get(accumulated)) + by
        self.put(accumulated, math.wrap(exact, 32))
        if exact != self.get(accumulated):
            beyond, back = ("OV", "UN") if by > 0 else ("UN", "OV")
            if self.get(counter.member(back)):
                self.put(counter.member(back), False)
            else:
                self.put(counter.member(beyond), True)

    def _ctu(self, power: bool, counter: Group) -> None:
        self._count(power, counter, "CU", 1)

    def _ctd(self, power: bool, counter: Group) -> None:
        self._count(power, counter, "CD", -1)

    def _res(self, structure: Group) -> None:
        for member in _structure(structure).members:
            if member.name not in ("PRE", "LEN"):
                self.put(structure.member(member.name), member.type.zero)

    # --- compare

    def _compare(self, relation: str, a: Resolved, b: Resolved) -> bool:
        if isinstance(a, (Group, Quoted)):
            return _RELATIONS[relation](self._text(a), self._text(b))
        width = width_of(a, b)
        left, right = self._number(a, width), self._number(b, width)
        return _RELATIONS[relation](left, right)

    def _text(self, operand: Resolved) -> bytes:
        if isinstance(operand, Quoted):
            return operand.value.encode("latin-1", errors="replace")
        assert isinstance(operand, Group)
        first = region_of(operand, self._memory.layout).first(
            lambda index, length: self._subscript(index, length, operand.text)
        )
        return self._memory.text(operand.path, first)

    def _cmp(self, condition: Resolved) -> bool:
        assert isinstance(condition, Calculation)
        if condition.name in RELATIONS:
            return self._compare(condition.name, *condition.operands)
        values = [self._cmp(each) for each in condition.operands]
        return _TRUTH[condition.name](*values)

    def _lim(self, low: Resolved, test: Resolved, high: Resolved) -> bool:
        width = width_of(low, test, high)
        least, value, most = (self._number(each, width) for each in (low, test, high))
        if least <= most:
            return least <= value <= most
        return value >= least or value <= most

    def _meq(self, source: Resolved, mask: Resolved, compare: Resolved) -> bool:
        different = self._filled(source) ^ self._filled(compare)
        return different & self._filled(mask) == 0

    def _filled(self, operand: Resolved) -> int:
        """An integer as unsigned: a narrow one is filled up with zeros."""
        assert isinstance(operand, (Place, Constant))
        return self._integer(operand) & (1 << operand.type.bits) - 1

    # --- compute

    def _cpt(self, target: Place, expression: Resolved) -> None:
        self._before()
        self._store(target, self._number(expression, width_of(expression, target)))

    def _sqr(self, source: Resolved, target: Place) -> None:
        self._compute("SQR", (source,), target)

    def _trn(self, source: Resolved, target: Place) -> None:
        self._before()
        value = self._number(source, width_of(source))
        if isinstance(value, float):
            if not math.finite(value):
                self._trouble.overflow(self._site)
            value = math.truncated(value)
        self._store(target, value)

    # --- move and logical

    def _mov(self, source: Resolved, target: Place) -> None:
        self._before()
        self._store(target, self._number(source, width_of(source)))

    def _combine(self, target: Place, value: int) -> None:
        """Set an integer to the low bits of a pattern; nothing overflows."""
        self._before()
        stored = math.wrap(value, target.type.bits)
        self.put(target, stored)
        self._after(stored)

    def _and(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) & self._filled(b))

    def _or(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) | self._filled(b))

    def _xor(self, a: Resolved, b: Resolved, target: Place) -> None:
        self._combine(target, self._filled(a) ^ self._filled(b))

    def _not(self, source: Resolved, target: Place) -> None:
        self._combine(target, ~self._filled(source))

    def _mvm(self, source: Resolved, mask: Resolved, target: Place) -> None:
        before, bits = int(self.get(target)), self._filled(mask)
        self._combine(target, before & ~bits | self._filled(source) & bits)

    def _btd(
        self, source: Resolved, source_bit: Constant, target: Place, target_bit: Constant, length: Constant
    ) -> None:
        value = math.distributed(
            self._filled(source),
            int(source_bit.value),
            int(self.get(target)),
            int(target_bit.value),
            int(length.value),
            target.type.bits,
        )
        self.put(target, value)

    def _clr(self, target: Place) -> None:
        self._before()
        self.put(target, target.type.zero)
        self._after(0)

    def _swpb(self, source: Place, mode: str, target: Place) -> None:
        self.put(target, math.swapped(int(self.get(source)), source.type.bits, mode))

    # --- files

    def _cop(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        regions = [region_of(each, self._memory.layout) for each in (source, target)]
        firsts = [
            each.first(lambda index, most, each=each: self._subscript(index, most, each.text))  # type: ignore[misc]
            for each in regions
        ]
        copy(self._memory, regions[0], firsts[0], regions[1], firsts[1], self._integer(length))

    def _fll(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        region = region_of(target, self._memory.layout)
        first = region.first(lambda index, most: self._subscript(index, most, region.text))
        count = min(self._integer(length), region.left(first))
        value = self._number(source, width_of(source))
        leaf = region.parts[0].leaf
        for number in range(count):
            element = Place(leaf, (), None, region.text)
            self._memory.write(leaf, first + number, self._converted(element, value))

    def _converted(self, place: Place, value: Value) -> Value:
        """Convert as FLL does: without flags and faults."""
        if place.type.is_real:
            return math.real(value)
        return math.wrap(math.whole(value) if isinstance(value, float) else int(value), place.type.bits)

    # --- program control

    def _jmp(self, label: str) -> None:
        raise _Jump(label)

    def _jsr(self, call: Call) -> None:
        site, inputs = self._site, self._inputs
        values = [self._value(each) for each in call.inputs]
        answers = self.run(call.routine, values)
        self._site, self._inputs = site, inputs
        for place, value in zip(call.returns, answers, strict=False):
            self._before()
            self._store(place, value)

    def _value(self, operand: Resolved) -> Value:
        return operand.value if isinstance(operand, Constant) else self.get(_place(operand))

    def _sbr(self, *targets: Place) -> bool:
        for place, value in zip(targets, self._inputs, strict=True):
            self._before()
            self._store(place, value)
        return True

    def _ret(self, *values: Resolved) -> None:
        raise _Return(tuple(map(self._value, values)))

    def _tnd(self) -> None:
        raise _Return(())

    def _mcr(self, power: bool) -> None:
        if not power:
            self._set_leaf(OVERRIDE, not self._leaf(OVERRIDE))

    # --- prescan

    def prescan(self, name: str | None = None) -> None:
        """Execute every rung of a routine as false, and those it calls; jumps are not taken."""
        routine = self._linked.routines.get(self._linked.main if name is None else name)
        for line in routine.lines if routine else ():
            self._prescan_series(line.nodes)

    def _prescan_series(self, nodes: tuple[Node, ...]) -> None:
        for node in nodes:
            if isinstance(node, Parallel):
                for leg in node.legs:
                    self._prescan_series(leg)
            else:
                self._prescan_step(node)

    def _prescan_step(self, step: Step) -> None:
        self._site = step.site
        if step.name == "JSR":
            self.prescan(step.operands[0].routine)
            return
        if step.name == ADD_ON:
            self._prescan_add_on(step.operands[0])
            return
        action = _PRESCAN.get(step.name)
        if action:
            try:
                action(self, *step.operands)
            except LadderFault:
                return  # tags that subscripts are computed from are not current yet

    def _prescan_add_on(self, call: AddOnCall) -> None:
        """Logic is prescanned, then the Prescan routine runs [1756-PM010]."""
        self.put(call.enable_in, False)
        self.put(call.enable_out, False)
        self.prescan(call.logic)
        if call.prescan is not None:
            self._inputs = ()
            self.run(call.prescan, ())

    def _prescan_ote(self, bit: Place) -> None:
        self.put(bit, False)

    def _prescan_ons(self, storage: Place) -> None:
        self.put(storage, True)

    def _prescan_osr(self, storage: Place, output: Place) -> None:
        self.put(storage, True)
        self.put(output, False)

    def _prescan_osf(self, storage: Place, output: Place) -> None:
        self.put(storage, False)
        self.put(output, False)

    def _prescan_ton(self, timer: Group) -> None:
        self._ton(False, timer)

    def _prescan_rto(self, timer: Group) -> None:
        self._set_bits(timer, EN=False, TT=False, DN=False)

    def _prescan_tof(self, timer: Group) -> None:
        self._set_bits(timer, EN=False, TT=False, DN=False)
        self.put(timer.member("ACC"), self.get(timer.member("PRE")))

    def _prescan_ctu(self, counter: Group) -> None:
        self.put(counter.member("CU"), True)

    def _prescan_ctd(self, counter: Group) -> None:
        self.put(counter.member("CD"), True)


def width_of(*operands: Resolved) -> int:
    """Return the width in which operands are computed together: 0 for REAL, 64 with a LINT, else 32."""
    types = set().union(*map(types_in, operands))
    if REAL in types:
        return 0
    return LINT.bits if LINT in types else DINT.bits


def _place(operand: Resolved) -> Place:
    assert isinstance(operand, Place)
    return operand


def _structure(group: Group) -> Any:
    return group.type


_WHOLE: Mapping[str, Callable[..., int]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": math.quotient,
    "MOD": math.remainder,
    "**": lambda a, b: math.truncated(math.power(float(a), float(b))),
    "AND": lambda a, b: a & b,
    "OR": lambda a, b: a | b,
    "XOR": lambda a, b: a ^ b,
    "NOT": lambda a: ~a,
    "NEG": lambda a: -a,
    "ABS": abs,
    "SQR": math.integer_root,
    "TRN": lambda a: a,
}

_REAL: Mapping[str, Callable[..., float]] = {
    "+": lambda a, b: math.real(a + b),
    "-": lambda a, b: math.real(a - b),
    "*": math.real_product,
    "/": math.real_quotient,
    "MOD": math.real_remainder,
    "**": math.power,
    "NEG": lambda a: -a,
    "ABS": abs,
    "SQR": math.square_root,
    "TRN": lambda a: math.real(math.truncated(a)),
}

_RELATIONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}

_TRUTH: Mapping[str, Callable[..., bool]] = {
    "AND": lambda a, b: a and b,
    "OR": lambda a, b: a or b,
    "XOR": lambda a, b: a != b,
    "NOT": lambda a: not a,
}

COMPARISONS = {"EQU": "=", "NEQ": "<>", "LES": "<", "LEQ": "<=", "GRT": ">", "GEQ": ">="}
"""Relation by compare instruction."""

COMPUTATIONS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "NEG": "NEG", "ABS": "ABS"}
"""Operator by compute instruction."""


def _comparing(relation: str) -> Callable[..., bool]:
    return lambda self, a, b: self._compare(relation, a, b)


def _computing(operator: str) -> Callable[..., None]:
    return lambda self, *operands: self._compute(operator, operands[:-1], operands[-1])


_INPUTS: dict[str, Callable[..., bool]] = {
    **{name: _comparing(relation) for name, relation in COMPARISONS.items()},
    "XIC": Interpreter._xic,
    "XIO": Interpreter._xio,
    "CMP": Interpreter._cmp,
    "LIM": Interpreter._lim,
    "MEQ": Interpreter._meq,
    "LBL": lambda _self, _label: True,
    "SBR": Interpreter._sbr,
    "AFI": lambda _self: False,
    "NOP": lambda _self: True,
}

_OUTPUTS: dict[str, Callable[..., None]] = {
    **{name: _computing(operator) for name, operator in COMPUTATIONS.items()},
    "OTL": Interpreter._otl,
    "OTU": Interpreter._otu,
    "RES": Interpreter._res,
    "CPT": Interpreter._cpt,
    "SQR": Interpreter._sqr,
    "TRN": Interpreter._trn,
    "MOV": Interpreter._mov,
    "MVM": Interpreter._mvm,
    "BTD": Interpreter._btd,
    "CLR": Interpreter._clr,
    "SWPB": Interpreter._swpb,
    "AND": Interpreter._and,
    "OR": Interpreter._or,
    "XOR": Interpreter._xor,
    "NOT": Interpreter._not,
    "COP": Interpreter._cop,
    "CPS": Interpreter._cop,
    "FLL": Interpreter._fll,
    "JMP": Interpreter._jmp,
    "JSR": Interpreter._jsr,
    "RET": Interpreter._ret,
    "TND": Interpreter._tnd,
}

_BOTH: Mapping[str, Callable[..., None]] = {
    "OTE": Interpreter._ote,
    "OSR": Interpreter._osr,
    "OSF": Interpreter._osf,
    "TON": Interpreter._ton,
    "TOF": Interpreter._tof,
    "RTO": Interpreter._rto,
    "CTU": Interpreter._ctu,
    "CTD": Interpreter._ctd,
    "MCR": Interpreter._mcr,
}

_PRESCAN: Mapping[str, Callable[..., None]] = {
    "OTE": Interpreter._prescan_ote,
    "ONS": Interpreter._prescan_ons,
    "OSR": Interpreter._prescan_osr,
    "OSF": Interpreter._prescan_osf,
    "TON": Interpreter._prescan_ton,
    "RTO": Interpreter._prescan_rto,
    "TOF": Interpreter._prescan_tof,
    "CTU": Interpreter._prescan_ctu,
    "CTD": Interpreter._prescan_ctd,
}
"""What prescan does; all other instructions do nothing then."""
