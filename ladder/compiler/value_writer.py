"""Operands in Python: reading, writing, computing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ..model.arithmetic import real
from ..model.operands import (
    DOUBLE,
    SINGLE,
    Calculation,
    Constant,
    Group,
    Place,
    Resolved,
    StringConstant,
    can_fault,
    first_leaf,
    is_truth,
    width_of,
)
from ..model.operators import BITWISE, FUNCTIONS, RELATIONS
from ..model.stretches import BITS, Spot, row_strides
from ..model.tags import OWN, FrameLayout, Leaf
from ..model.types import DINT, LINT, LREAL, REAL, Elementary
from .packed import assign_packed, read_packed
from .string_places import StringPlace
from .writer import Writer

_REAL_HOLDS = 1 << 127  # integers up to this size never overflow a REAL

PYTHON_RELATION = {"=": "==", "<>": "!=", **{each: each for each in RELATIONS[2:]}}


@dataclass(frozen=True, slots=True)
class Term:
    """A value as Python text."""

    text: str  # an expression: a name, a number or something in parentheses
    low: int = 0  # lowest possible value, for an integer
    high: int = 0  # highest possible value
    real: bool = False  # whether it is a floating-point number
    double: bool = False  # whether it needs rounding to be a REAL

    def fits(self, bits: int) -> bool:
        """Whether it is an integer that never overflows that many bits."""
        half = 1 << bits - 1
        return not self.real and -half <= self.low and self.high < half


class ValueWriter:
    """Writes operands."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self.site = 0

    # --- reading

    def read(self, place: Place) -> str:
        """Return text for the value of a place."""
        if self.is_packed(place.leaf):
            return read_packed(self, place)
        whole = self.whole(place)
        if place.bit is None:
            mask = self.writer.mask(place.leaf)
            return f"({whole} if {mask} is None else {whole} & {mask} != 0)" if mask else whole
        if isinstance(place.bit, Constant):
            number = int(place.bit.value)
            if number == place.leaf.type.bits - 1 and place.leaf.type.is_signed:
                return f"({whole} < 0)"
            return f"({whole} & {1 << number} != 0)"
        if calculates(place.bit) and any(not isinstance(each, Constant) for each in place.indices):
            whole = self.keep(whole)  # see `terms`
        number_text = self.index(place.bit, place.leaf.type.bits, place.text)
        return f"({whole} >> {number_text} & 1 != 0)"

    def whole(self, place: Place) -> str:
        """Return text for the value that a place is, or is a bit of."""
        name, element = self.writer.name(place.leaf), self.element(place)
        return f"{name}[{element}]" if element else name

    def is_packed(self, leaf: Leaf) -> bool:
        """Whether a leaf is bits of bytes."""
        spot = self.writer.layout.spot(leaf)
        return spot is not None and spot.view == BITS

    def element(self, place: Place) -> str:
        """Return text for the list index of a place, "" without a list."""
        leaf = place.leaf
        if not leaf.dims and self.writer.layout.spot(leaf) is None:
            return ""
        return self.offset(leaf, self.subscripts(leaf, place.indices, place.text))

    def subscripts(self, leaf: Leaf, indices: Sequence[Resolved], tag: str) -> list[str]:
        """Return texts for the checked subscripts of a leaf."""
        lengths: list[int | str] = [*leaf.dims]
        if left := self.writer.left(leaf):
            lengths[0] = left
        texts = []
        for position, (index, length) in enumerate(zip(indices, lengths, strict=False), start=1):
            text = self.index(index, length, tag)
            first = not text.isdigit() and any(map(calculates, indices[position:]))
            texts.append(self.keep(text) if first else text)  # see `terms`
        return texts

    def offset(self, leaf: Leaf, subscripts: Sequence[str]) -> str:
        """Return text for the list index of a value, from its subscripts' texts."""
        return self.placed(self.writer.layout.spot(leaf), leaf, subscripts)

    def placed(self, spot: Spot | None, leaf: Leaf, subscripts: Sequence[str]) -> str:
        """Return text for an index from subscripts' texts; of a structure in bytes its first byte."""
        fixed, strides = (spot.part.offset, spot.strides) if spot else (0, row_strides(leaf.dims, 1))
        base = self.writer.base(leaf, spot) if spot else ""
        terms = [base] if base else []
        for text, stride in zip(subscripts, strides, strict=False):
            if text.isdigit():
                fixed += int(text) * stride
            else:
                terms.append(f"{text} * {stride}" if stride != 1 else text)
        return " + ".join([*terms, str(fixed)] if fixed or not terms else terms)

    def row(self, leaf: Leaf, number: int) -> str:
        """Return text for the list index of an element, from its flat index."""
        spot = self.writer.layout.spot(leaf)
        if spot is None:
            return str(number)
        at, base = str(spot.at(number)), self.writer.base(leaf, spot)
        return f"{base} + {at}" if base else at

    def flat(self, leaf: Leaf, indices: Sequence[Resolved], tag: str) -> str:
        """Return text for the flat index of an element."""
        strides = row_strides(leaf.dims[: len(indices)], 1)
        texts = self.subscripts(leaf, indices, tag)
        if all(text.isdigit() for text in texts):
            return str(sum(int(text) * stride for text, stride in zip(texts, strides, strict=True)))
        each = [
            f"{text} * {stride}" if stride != 1 else text for text, stride in zip(texts, strides, strict=True)
        ]
        return " + ".join(each)

    def index(self, index: Resolved, length: int | str, tag: str) -> str:
        """Return text for a checked subscript; a length may be a variable."""
        if isinstance(index, Constant):
            value = str(index.value)
            return value if isinstance(length, int) else f"subscript({value}, {length}, {self.site}, {tag!r})"
        term = self.term(index, DINT.bits)
        if term.text.isidentifier():
            name = term.text
            return f"({name} if 0 <= {name} < {length} else outside({name}, {length}, {self.site}, {tag!r}))"
        return f"subscript({term.text}, {length}, {self.site}, {tag!r})"

    # --- writing

    def assign(self, place: Place, text: str) -> None:
        """Write an assignment to a place other than a bit of a tag."""
        self.writer.assigned(place.leaf)
        if self.is_packed(place.leaf):
            assign_packed(self, place, text)
            return
        whole = self.whole(place)
        mask = self.writer.mask(place.leaf)
        if not mask:
            self.writer.line(f"{whole} = {text}")
            return
        value = self.keep(text)
        with self.writer.block(f"if {mask} is None:"):
            self.writer.line(f"{whole} = {value}")
        with self.writer.block("else:"):
            self.writer.line(f"{whole} = {whole} | {mask} if {value} else {whole} & ~{mask}")

    def set_bit(self, place: Place, power: str) -> None:
        """Write an assignment of a bool expression to a bit."""
        if place.bit is None:
            self.assign(place, power)
            return
        self.writer.assigned(place.leaf)
        target = self.writer.name(place.leaf)
        element = self.element(place)
        if element:
            if "(" in element:
                element = self.keep(element)
            target = f"{target}[{element}]"
        bits = place.leaf.type.bits
        if isinstance(place.bit, Constant):
            number = int(place.bit.value)
            top = number == bits - 1 and place.leaf.type.is_signed
            on, off = (
                (place.leaf.type.lowest, place.leaf.type.highest) if top else (1 << number, ~(1 << number))
            )
            changed = {"True": f"{target} | {on}", "False": f"{target} & {off}"}.get(power)
            self.writer.line(f"{target} = {changed or f'{target} | {on} if {power} else {target} & {off}'}")
            return
        mask = self.keep(f"1 << {self.index(place.bit, bits, place.text)}")
        self.writer.line(
            f"{target} = wrap({target} | {mask} if {power} else {target} & ~{mask}, {place.leaf.type.wraps})"
        )

    def store(self, place: Place, term: Term, width: int) -> None:
        """Write lines that convert and store a number and set S:Z and S:N."""
        self.assign_result(place, self.converted(term, place.type, width))

    def converted(self, term: Term, kind: Elementary, width: int) -> str:
        """Return text for a number converted to a type."""
        if kind.is_real:
            return self._as_real(term)
        if kind.is_double:
            return term.text if term.real else f"float({term.text})"
        if term.real:
            return f"integer({self.site}, {term.text}, {kind.wraps})"
        if kind.lowest <= term.low and term.high <= kind.highest and term.fits(width or 64):
            return term.text
        least = max(kind.lowest, -1 << (width or 64) - 1)
        most = min(kind.highest, (1 << (width or 64) - 1) - 1)
        value = self.keep(term.text)
        otherwise = f"narrow({self.site}, {value}, {width or 64}, {kind.wraps})"
        return f"{value} if {least} <= {value} <= {most} else {otherwise}"

    def _as_real(self, term: Term) -> str:
        """Return text for a number rounded to REAL."""
        if term.double or -term.low > _REAL_HOLDS or term.high > _REAL_HOLDS:
            value = self.keep(term.text)
            return f"real_result({self.site}, {value}, {value})"
        exact = term.low >= -(1 << 24) and term.high <= 1 << 24
        return term.text if term.real else f"float({term.text})" if exact else f"real({term.text})"

    def assign_result(self, place: Place, text: str) -> None:
        """Write an assignment of a result, and S:Z and S:N from it even if the place is forced."""
        if not self.writer.flags:
            self.assign(place, text)
            return
        value = self.keep(text)
        self.assign(place, value)
        self.result_flags(value)

    def result_flags(self, value: str) -> None:
        """Write S:Z and S:N of a value."""
        self.set_flag("S:Z", f"{value} == 0")
        self.set_flag("S:N", f"{value} < 0")

    def set_flag(self, name: str, text: str) -> None:
        """Write an assignment of a status flag."""
        leaf = self.writer.lowered.layout.leaf(name)
        self.writer.assigned(leaf)
        self.writer.line(f"{self.writer.name(leaf)} = {text}")

    def clear_flags(self) -> None:
        """Write the reset of S:V and S:C."""
        if self.writer.flags:
            self.set_flag("S:V", "False")
            self.set_flag("S:C", "False")

    def keep(self, text: str) -> str:
        """Store a value in a variable; return its name."""
        if text.isidentifier() and text.startswith("__"):
            return text
        name = self.writer.temporary()
        self.writer.line(f"{name} = {text}")
        return name

    # --- computing

    def term(self, operand: Resolved, width: int) -> Term:
        """Return a number, computed in integers of that width, or in SINGLE or DOUBLE."""
        if isinstance(operand, Calculation):
            if is_truth(operand):
                kind = "int" if width > 0 else "float"
                text = self.keep(f"{kind}({self.condition(operand)})")
                return Term(text, 0, 1) if width > 0 else Term(text, real=True, double=width == DOUBLE)
            if width <= 0 and operand.name in BITWISE:
                return self._floating(self.term(operand, width_of(operand)), width)
            terms = self.terms(operand.operands, width)
            if width <= 0:
                result = self.real_operation(operand.name, terms, width)
                return replace(result, text=self.keep(result.text))
            return self.narrowed(operand.name, terms, width)
        term = self.leaf_term(operand, width)
        if width == SINGLE and term.double:
            return Term(f"real({term.text})", real=True)
        return term if width > 0 or term.real else self._floating(term, width)

    def _floating(self, term: Term, width: int) -> Term:
        """Convert an integer term to the precision of SINGLE or DOUBLE."""
        kind = REAL if width == SINGLE else LREAL
        return Term(self.converted(term, kind, LINT.bits), real=True, double=kind is LREAL)

    def terms(self, operands: Sequence[Resolved], width: int) -> list[Term]:
        """Return numbers; any fault occurs before later operands write lines."""
        found = []
        for position, operand in enumerate(operands, start=1):
            term = self.term(operand, width)
            if any(map(calculates, operands[position:])) and can_fault(operand):
                term = replace(term, text=self.keep(term.text))
            found.append(term)
        return found

    def leaf_term(self, operand: Resolved, width: int = SINGLE) -> Term:
        """Return a constant or a place; DOUBLE keeps all digits of a constant."""
        if isinstance(operand, Constant):
            value = operand.value
            if isinstance(value, float):
                text = repr(value if width == DOUBLE else real(value))
                double = width == DOUBLE
                return Term(text if text[-1].isdigit() else f'float("{text}")', real=True, double=double)
            return Term(str(value) if value >= 0 else f"({value})", value, value)
        assert isinstance(operand, Place)
        return self.term_of(self.read(operand), operand.type)

    def term_of(self, text: str, kind: Elementary) -> Term:
        """Return a value of a type."""
        if kind.is_real or kind.is_double:
            return Term(text, real=True, double=kind.is_double)
        return Term(text, kind.lowest, kind.highest)

    def narrowed(self, name: str, terms: list[Term], width: int) -> Term:
        """Return an integer operation wrapped to its width."""
        exact = self.operation(name, terms)
        if exact.fits(width):
            # faults are recorded now, before other operands are read
            return Term(self.keep(exact.text), exact.low, exact.high) if name in ("/", "MOD") else exact
        value = self.keep(exact.text)
        half = 1 << width - 1
        wrapped = f"{value} = narrow({self.site}, {value}, {width}, {width})"
        self.writer.line(f"if not {-half} <= {value} <= {half - 1}: {wrapped}")
        return Term(value, -half, half - 1)

    def operation(self, name: str, terms: list[Term]) -> Term:
        """Return an integer operation without wrapping."""
        texts = [each.text for each in terms]
        a = terms[0]
        b = terms[-1]
        size = max(abs(each) for term in terms for each in (term.low, term.high))
        if name in ("+", "-", "*"):
            low, high = _RANGES[name](a, b)
            return Term(f"({texts[0]} {name} {texts[1]})", low, high)
        if name in ("/", "MOD"):
            function = "divide" if name == "/" else "modulo"
            return Term(f"{function}({self.site}, {texts[0]}, {texts[1]})", -size, size)
        if name in ("AND", "OR", "XOR"):
            bits = size.bit_length()
            sign = {"AND": "&", "OR": "|", "XOR": "^"}[name]
            return Term(f"({texts[0]} {sign} {texts[1]})", -(1 << bits), (1 << bits) - 1)
        if name == "**":
            return Term(f"truncated(power(float({texts[0]}), float({texts[1]})))", -(1 << 4000), 1 << 4000)
        if name == "NOT":
            return Term(f"(~{texts[0]})", ~a.high, ~a.low)
        if name == "NEG":
            return Term(f"(-{texts[0]})", -a.high, -a.low)
        row = FUNCTIONS[name]
        assert row.whole is not None
        return Term(f"{row.whole.__name__}({texts[0]})", 0 if row.positive else a.low, row.most or size)

    def real_operation(self, name: str, terms: list[Term], width: int) -> Term:
        """Return an operation in SINGLE or DOUBLE."""
        texts = [each.text for each in terms]
        kind = "real" if width == SINGLE else "double"
        if name in ("+", "-", "*", "**"):
            kept = [each if _simple(each) else self.keep(each) for each in texts]
            exact = f"power({kept[0]}, {kept[1]})" if name == "**" else f"{kept[0]} {name} {kept[1]}"
            text = f"{kind}_result({self.site}, {exact}, {kept[0]}, {kept[1]})"
        elif name in ("/", "MOD"):
            text = f"{kind}_{'divide' if name == '/' else 'modulo'}({self.site}, {texts[0]}, {texts[1]})"
        elif name == "NEG":
            text = f"(-{texts[0]})"
        else:
            function = FUNCTIONS[name]
            value = texts[0] if function.safe or _simple(texts[0]) else self.keep(texts[0])
            text = f"{function.real.__name__}({value})"
            if not function.safe:
                text = f"{kind}_result({self.site}, {text}, {value})"
            elif width == SINGLE and name not in ("ABS", "TRN"):  # which are exact of a REAL
                text = f"real({text})"
        return Term(text, real=True, double=width == DOUBLE)

    def compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        """Write lines that store the result of an operator; S:C is its carry."""
        self.clear_flags()
        width = width_of(Calculation(name, operands), target)
        if self.writer.flags and width > 0 and name in _CARRIES:
            self._carry(name, operands, width)
        terms = self.terms(operands, width)
        result = self.operation(name, terms) if width > 0 else self.real_operation(name, terms, width)
        self.store(target, result, width)

    def expression(self, target: Place, expression: Resolved) -> None:
        """Write lines that store the value of an expression."""
        self.clear_flags()
        width = width_of(expression, target)
        self.store(target, self.term(expression, width), width if width <= 0 else LINT.bits)

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> None:
        mask = (1 << width) - 1
        texts = [f"({self.term(each, width).text} & {mask})" for each in operands]
        self.set_flag("S:C", _CARRIES[name](texts[0], texts[-1], mask))

    def store_wide(self, target: Place, term: Term) -> None:
        """Write lines that store an integer of any width."""
        kind = target.type
        if not kind.is_integer or term.fits(LINT.bits):
            self.store(target, term, LINT.bits)
            return
        value = self.keep(term.text)
        otherwise = f"narrow({self.site}, {value}, 256, {kind.wraps})"
        self.assign_result(target, f"{value} if {kind.lowest} <= {value} <= {kind.highest} else {otherwise}")

    def store_bits(self, target: Place, text: str, *, direct: bool) -> None:
        """Write lines that store a bit pattern in an integer; `direct`: it has the target's width."""
        self.clear_flags()
        result = text if direct and target.type.is_signed else f"wrap({text}, {target.type.wraps})"
        self.assign_result(target, result)

    # --- comparing

    def comparison(self, relation: str, a: Resolved, b: Resolved) -> str:
        """Return text for a relation."""
        sign = PYTHON_RELATION[relation]
        if isinstance(a, (Group, StringConstant)):
            return f"({self.characters(a)} {sign} {self.characters(b)})"
        left, right = self.terms((a, b), width_of(a, b))
        return f"({left.text} {sign} {right.text})"

    def characters(self, operand: Resolved) -> str:
        """Return text for the characters of a STRING."""
        if isinstance(operand, StringConstant):
            return repr(operand.value.encode("latin-1", errors="replace"))
        assert isinstance(operand, Group)
        place = self.string(operand)
        if place is None:
            return f"text{self._in_store(operand)})"
        return place.read(self.writer.temporary(), f"chars({place})") if place.is_fixed else f"chars({place})"

    def set_characters(self, operand: Group, text: str) -> None:
        """Write an assignment of characters, in a variable, to a string."""
        place = self.string(operand)
        if place is None:
            self.writer.line(f"set_text{self._in_store(operand)}, {text})")
        else:
            self.writer.line(
                place.store(text, f"len({text}) if len({text}) < {place.room} else {place.room}")
            )

    def string(self, operand: Group) -> StringPlace | None:
        """Return the place of a STRING in bytes, None of others."""
        spot = self.writer.layout.byte_spot(operand.path)
        if spot is None:
            return None
        texts = self.subscripts(first_leaf(operand), operand.indices, operand.text)
        room = operand.layout.leaf(f"{operand.path}.DATA").dims[-1]
        return StringPlace(spot.ident, self.placed(spot, first_leaf(operand), texts), room)

    def _in_store(self, operand: Group) -> str:
        """Return text for the arguments that find a string: path, index, store."""
        path, leaf = operand.path, first_leaf(operand)
        first = self.flat(leaf, operand.indices, operand.text)
        if not leaf.root:
            return f"({path!r}, {first}"
        return f"_in({self.store_of(leaf)}, {leaf.frame!r}, {path!r}, {first}"

    def stores(self) -> str:
        """Return text for all stores of an add-on instruction by `Leaf.root`, "" in a program."""
        layout = self.writer.layout
        if not isinstance(layout, FrameLayout):
            return ""
        parts = {root: ", ".join(self.writer.handed(root)) for root in (OWN, *layout.inouts)}
        return (
            "{"
            + ", ".join(f"{root!r}: stretch({layout.frame!r}, {each})" for root, each in parts.items())
            + "}"
        )

    def store_of(self, leaf: Leaf) -> str:
        """Return text for the store of a leaf; None is the program's memory."""
        if not leaf.root:
            return "None"
        return f"stretch({leaf.frame!r}, {', '.join(self.writer.handed(leaf.root))})"

    def condition(self, condition: Resolved) -> str:
        """Return text for a condition; all parts are computed unless they have no effect."""
        if isinstance(condition, Place):
            return self.read(condition)
        if isinstance(condition, Constant):
            return str(bool(condition.value))
        assert isinstance(condition, Calculation)
        if condition.name in RELATIONS and not any(map(is_truth, condition.operands)):
            return self.comparison(condition.name, *condition.operands)
        texts = [self.condition(each) for each in condition.operands if is_plain(condition)]
        texts = texts or [self.keep(self.condition(each)) for each in condition.operands]
        if condition.name == "NOT":
            return f"(not {texts[0]})"
        sign = {"AND": "and", "OR": "or", "XOR": "!="}.get(condition.name) or PYTHON_RELATION[condition.name]
        return f"({texts[0]} {sign} {texts[1]})"

    def filled(self, operand: Resolved, bits: int) -> str:
        """Return an integer, zero-extended to `bits`."""
        term = self.leaf_term(operand)
        assert isinstance(operand, (Place, Constant))
        own = operand.type.bits
        return f"({term.text} & {(1 << own) - 1})" if own < bits else term.text


def calculates(operand: Resolved) -> bool:
    """Whether an operand or its subscripts contain a calculation, which may need its own lines."""
    if isinstance(operand, Calculation):
        return True
    if isinstance(operand, (Place, Group)):
        inner = [*operand.indices]
        if isinstance(operand, Place) and operand.bit is not None:
            inner.append(operand.bit)
        return any(map(calculates, inner))
    return False


def is_plain(condition: Resolved) -> bool:
    """Whether a condition is one expression without effects or faults."""
    if can_fault(condition):
        return False
    if not isinstance(condition, Calculation):
        return True
    return (condition.name in RELATIONS or is_truth(condition)) and all(map(is_plain, condition.operands))


def _simple(text: str) -> bool:
    return text.isidentifier() or text.replace(".", "").isdigit()


_CARRIES: dict[str, Callable[[str, str, int], str]] = {
    "+": lambda a, b, mask: f"{a} + {b} > {mask}",
    "-": lambda a, b, _mask: f"{a} < {b}",
    "NEG": lambda a, _b, _mask: f"{a} != 0",
}
"""Text for the carry of an operator on operands without sign."""

_RANGES: dict[str, Callable[[Term, Term], tuple[int, int]]] = {
    "+": lambda a, b: (a.low + b.low, a.high + b.high),
    "-": lambda a, b: (a.low - b.high, a.high - b.low),
    "*": lambda a, b: _product(a, b),
}


def _product(a: Term, b: Term) -> tuple[int, int]:
    corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
    return min(corners), max(corners)
