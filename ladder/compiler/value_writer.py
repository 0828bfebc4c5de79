"""Operands as Python code: computing, comparing and storing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

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
    is_truth,
    width_of,
)
from ..model.operators import BITWISE, FUNCTIONS, RELATIONS
from ..model.types import LINT, LREAL, REAL, Elementary
from .place_writer import PlaceWriter
from .terms import CARRIES, Term, calculates, integer_operation, is_plain

PYTHON_RELATION = {"=": "==", "<>": "!=", **{relation: relation for relation in RELATIONS[2:]}}

_REAL_RANGE = 1 << 127  # integers up to this size fit a REAL


class ValueWriter(PlaceWriter):
    """Writes operands: places, and calculations on them."""

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
        bits = width or LINT.bits
        if kind.lowest <= term.low and term.high <= kind.highest and term.fits(bits):
            return term.text
        least, most = max(kind.lowest, -1 << bits - 1), min(kind.highest, (1 << bits - 1) - 1)
        value = self.keep(term.text)
        otherwise = f"narrow({self.site}, {value}, {bits}, {kind.wraps})"
        return f"{value} if {least} <= {value} <= {most} else {otherwise}"

    def _as_real(self, term: Term) -> str:
        """Return text for a number rounded to REAL."""
        if term.double or -term.low > _REAL_RANGE or term.high > _REAL_RANGE:
            value = self.keep(term.text)
            return f"real_result({self.site}, {value}, {value})"
        exact = term.low >= -(1 << 24) and term.high <= 1 << 24
        if term.real:
            return term.text
        return f"float({term.text})" if exact else f"real({term.text})"

    def assign_result(self, place: Place, text: str) -> None:
        """Write an assignment of a result; S:Z and S:N follow the result even if the place is forced."""
        if not self.writer.flags:
            self.assign(place, text)
            return
        value = self.keep(text)
        self.assign(place, value)
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

    # --- computing

    def _truth(self, operand: Calculation, width: int) -> Term:
        """Return 1 or 0 for a condition."""
        condition = self.condition(operand)
        if width > 0:
            return Term(self.keep(f"int({condition})"), 0, 1)
        return Term(self.keep(f"float({condition})"), real=True, double=width == DOUBLE)

    def term(self, operand: Resolved, width: int) -> Term:
        """Return a number, computed in integers of that width, or in SINGLE or DOUBLE."""
        if isinstance(operand, Calculation):
            if is_truth(operand):
                return self._truth(operand, width)
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
        """Return operands as numbers; evaluate one that can fault before later operands write lines."""
        terms = []
        for position, operand in enumerate(operands, start=1):
            term = self.term(operand, width)
            if any(map(calculates, operands[position:])) and can_fault(operand):
                term = replace(term, text=self.keep(term.text))
            terms.append(term)
        return terms

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
        """Return text as a term with the range of a type."""
        if kind.is_real or kind.is_double:
            return Term(text, real=True, double=kind.is_double)
        return Term(text, kind.lowest, kind.highest)

    def narrowed(self, name: str, terms: list[Term], width: int) -> Term:
        """Return an integer operation wrapped to its width."""
        exact = integer_operation(name, terms, self.site)
        if exact.fits(width):
            # faults are recorded now, before other operands are read
            return Term(self.keep(exact.text), exact.low, exact.high) if name in ("/", "MOD") else exact
        value = self.keep(exact.text)
        half = 1 << width - 1
        wrapped = f"{value} = narrow({self.site}, {value}, {width}, {width})"
        self.writer.line(f"if not {-half} <= {value} <= {half - 1}: {wrapped}")
        return Term(value, -half, half - 1)

    def real_operation(self, name: str, terms: list[Term], width: int) -> Term:
        """Return an operation in SINGLE or DOUBLE; its text records a fault if the result is not finite."""
        texts = [term.text for term in terms]
        kind = "real" if width == SINGLE else "double"
        if name in ("+", "-", "*", "**"):
            operands = [text if _simple(text) else self.keep(text) for text in texts]
            exact = (
                f"power({operands[0]}, {operands[1]})"
                if name == "**"
                else f"{operands[0]} {name} {operands[1]}"
            )
            result = f"{kind}_result({self.site}, {exact}, {operands[0]}, {operands[1]})"
        elif name in ("/", "MOD"):
            result = f"{kind}_{'divide' if name == '/' else 'modulo'}({self.site}, {texts[0]}, {texts[1]})"
        elif name == "NEG":
            result = f"(-{texts[0]})"
        else:
            result = self._real_function(name, texts[0], width)
        return Term(result, real=True, double=width == DOUBLE)

    def _real_function(self, name: str, argument: str, width: int) -> str:
        """Return text for a function in SINGLE or DOUBLE, with a check of the result unless it is safe."""
        function = FUNCTIONS[name]
        if function.safe:
            is_exact = width != SINGLE or name in ("ABS", "TRN")  # exact for a REAL
            text = f"{function.real.__name__}({argument})"
            return text if is_exact else f"real({text})"
        value = argument if _simple(argument) else self.keep(argument)
        kind = "real" if width == SINGLE else "double"
        return f"{kind}_result({self.site}, {function.real.__name__}({value}), {value})"

    def compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        """Write lines that store the result of an operator; S:C is its carry."""
        self.clear_flags()
        width = width_of(Calculation(name, operands), target)
        if self.writer.flags and width > 0 and name in CARRIES:
            self._carry(name, operands, width)
        terms = self.terms(operands, width)
        result = (
            integer_operation(name, terms, self.site)
            if width > 0
            else self.real_operation(name, terms, width)
        )
        self.store(target, result, width)

    def expression(self, target: Place, expression: Resolved) -> None:
        """Write lines that store the value of an expression."""
        self.clear_flags()
        width = width_of(expression, target)
        self.store(target, self.term(expression, width), width if width <= 0 else LINT.bits)

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> None:
        """Write S:C, the carry of an operator on its operands as unsigned numbers."""
        mask = (1 << width) - 1
        texts = [f"({self.term(operand, width).text} & {mask})" for operand in operands]
        self.set_flag("S:C", CARRIES[name](texts[0], texts[-1], mask))

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
        """Write lines that store a bit pattern in an integer; `direct` means it has the target's width."""
        self.clear_flags()
        result = text if direct and target.type.is_signed else f"wrap({text}, {target.type.wraps})"
        self.assign_result(target, result)

    # --- comparing

    def comparison(self, relation: str, a: Resolved, b: Resolved) -> str:
        """Return text that compares two operands."""
        sign = PYTHON_RELATION[relation]
        if isinstance(a, (Group, StringConstant)):
            return f"({self.characters(a)} {sign} {self.characters(b)})"
        left, right = self.terms((a, b), width_of(a, b))
        return f"({left.text} {sign} {right.text})"

    def condition(self, condition: Resolved) -> str:
        """Return text for a condition; all its parts are evaluated if one has an effect."""
        if isinstance(condition, Place):
            return self.read(condition)
        if isinstance(condition, Constant):
            return str(bool(condition.value))
        assert isinstance(condition, Calculation)
        if condition.name in RELATIONS and not any(map(is_truth, condition.operands)):
            return self.comparison(condition.name, *condition.operands)
        plain = is_plain(condition)
        texts = [text if plain else self.keep(text) for text in map(self.condition, condition.operands)]
        if condition.name == "NOT":
            return f"(not {texts[0]})"
        sign = {"AND": "and", "OR": "or", "XOR": "!="}.get(condition.name) or PYTHON_RELATION[condition.name]
        return f"({texts[0]} {sign} {texts[1]})"

    def filled(self, operand: Resolved, bits: int) -> str:
        """Return an integer, zero-extended to `bits`."""
        term = self.leaf_term(operand)
        assert isinstance(operand, (Place, Constant))
        width = operand.type.bits
        return f"({term.text} & {(1 << width) - 1})" if width < bits else term.text


def _simple(text: str) -> bool:
    """Return whether text is a name or a number, which can be repeated without a calculation."""
    return text.isidentifier() or text.replace(".", "").isdigit()
