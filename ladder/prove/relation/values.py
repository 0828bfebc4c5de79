"""Values of a scan on terms: places, computing, comparing, converting; see `interpreter.values`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from ....io_images.site import Site
from ...interpreter import Interpreter
from ...model.errors import STRING_NUMBER_CODE
from ...model.operands import SINGLE, Calculation, Group, Place, Resolved, is_truth
from ...model.operators import RELATIONS
from ...model.tags import Leaf
from ...model.types import ULINT, Elementary, Field
from ...state.lowered import LoweredProgram
from ...state.memory import Store
from ...state.regions import ArrayRegion, End
from ..algebra.meaning import BOOL, F32, F64, INT
from ..algebra.numbers import (
    add,
    bitop,
    clip,
    div,
    eq,
    fop,
    inv,
    le,
    least,
    lt,
    mul,
    rem,
    sub,
    to_float,
    to_int,
    wrap,
)
from ..algebra.terms import FALSE, TRUE, T, and_, const, iff, ite, mk, not_, or_, var
from .copies import CopyRegions
from .faults import TermFaults
from .paths import PathFault, Paths, faults_of, merged, result_of, written_by
from .patterns import Byte, constant_bytes, unpack
from .places import AGE, CLOCK, Key, TermArgument, TermMemory, kind_of
from .symbols import FLOATS, TermSymbol, UnmodelledError, term_of, truth_of, whole_of
from .texts import TermText, digits, number_in

_FAR = 2.0**62
"""Floats from here on have no exact term as a whole number."""

MOST_FACTS = 64
"""Maximum truths that are known of a place in the program."""

_LARGEST = {F32: 1 << 128, F64: 1 << 1024}


class TermValues(Interpreter):
    """Reads and writes terms; `active` is whether the current instruction is reached at all."""

    argument_type = TermArgument

    parts = False
    """Whether scan times have parts of a ms: then each timer may count one ms more in a scan."""

    def __init__(self, lowered: LoweredProgram, dt: tuple[int, int], known: Mapping[Key, Any]) -> None:
        self.known = known  # values that never change
        self.state: dict[Key, T] = {}  # values now
        self.vars: dict[Key, T] = {}  # values before the scan: variables
        self.kinds: dict[Key, Leaf] = {}
        self.written: set[Key] = set()
        self.havocs: dict[str, Site] = {}  # variables for what is not modelled, and the instruction
        self.faults: list[tuple[int, T]] = []  # major faults: number of the instruction, condition
        self._lost: dict[str, list[T]] = {}  # where all of a leaf has become unknown, by path in capitals
        self._lost_by: dict[int, Site] = {}
        self._asked: dict[str, list[int]] = {}  # elements with a variable, by path in capitals
        self.active: T = TRUE
        self._facts_of, self._known_facts = TRUE, frozenset[int]()
        self.dt = var("~dt", INT, *dt)
        self.paths, self.regions = Paths(), CopyRegions(self)
        faults = TermFaults(self)
        super().__init__(lowered, TermMemory(self, lowered.layout), faults, _no_python)  # type: ignore[arg-type]

    @property
    def now_ns(self) -> int:
        """Refuse the clock: `start_clock` and `elapsed` have its place."""
        raise UnmodelledError("the clock is read")

    @now_ns.setter
    def now_ns(self, _value: int) -> None:
        """Take no time."""

    def symbol(self, t: T) -> Any:
        """Return a term as a number for rows, a constant as its value."""
        return t.val if t.op == "const" else TermSymbol(t, self.paths.decide)

    # --- places

    def peek(self, leaf: Leaf, index: int) -> T:
        """Return the term of a place."""
        key = leaf.path.upper(), index
        path = self.paths.path
        if path is not None and key in path.written:
            return path.written[key]
        known = self.state.get(key)
        return self._first(key, leaf) if known is None else self._reached(known)

    def _reached(self, t: T) -> T:
        """Return a term as it is where the current instruction is reached, which is all that counts there."""
        while t.op == "ite" and self.active is not TRUE:
            condition, held, other = t.args
            facts = self._facts()
            if condition.id in facts:
                t = held
            elif not_(condition).id in facts:
                t = other
            else:
                break
        return t

    def _facts(self) -> frozenset[int]:
        """Return the ids of truths that hold where the current instruction is reached."""
        if self._facts_of is not self.active:
            todo, found = [self.active], set[int]()
            while todo and len(found) < MOST_FACTS:
                t = todo.pop(0)
                found.add(t.id)
                todo.extend(t.args if t.op == "and" else ())
            self._facts_of, self._known_facts = self.active, frozenset(found)
        return self._known_facts

    def _first(self, key: Key, leaf: Leaf) -> T:
        """Make the variable of a place."""
        if key in self.known:
            self.state[key] = found = const(self.known[key], kind_of(leaf.type)[0])
            self._asked.setdefault(key[0], []).append(key[1])
            return found
        name = f"{key[0]}[{key[1]}]"
        if key[0].endswith(CLOCK):
            own = var(name, INT, 0, AGE)
            late = add(self.dt, var(f"~rest:{name}", INT, 0, 1)) if self.parts else self.dt
            now = least(add(own, late), AGE)
        else:
            own = now = var(name, *kind_of(leaf.type))
        for lost in self._lost.get(key[0], ()):
            now = ite(lost, self.unknown_of(leaf, self._lost_by[lost.id]), now)
            self.written.add(key)
        self._asked.setdefault(key[0], []).append(key[1])
        self.vars[key], self.kinds[key], self.state[key] = own, leaf, now
        return now

    def havoc(self, leaf: Leaf) -> None:
        """Let all elements of a leaf be anything where the current instruction is reached.

        Those that nothing has asked for so far become unknown once something does.
        """
        path = leaf.path.upper()
        for index in self._asked.get(path, ()):
            self.poke(leaf, index, self.unknown_of(leaf))
        self._lost.setdefault(path, []).append(self.active)
        self._lost_by[self.active.id] = self.lowered.sites[self.site]

    def poke(self, leaf: Leaf, index: int, t: T, guard: T = TRUE) -> None:
        """Set a place where the guard holds, to a value of its type."""
        key = leaf.path.upper(), index
        old = self.peek(leaf, index)
        self.written.add(key)
        t = self._fitting(t, leaf, key)
        path = self.paths.path
        if path is not None:
            path.written[key] = ite(guard, t, old)
        else:
            self.state[key] = ite(and_(self.active, guard), t, old)

    @staticmethod
    def _fitting(t: T, leaf: Leaf, key: Key) -> T:
        kind = leaf.type
        if kind.is_bool:
            return truth_of(t)
        if kind.is_real or kind.is_double:
            return to_float(t, F32 if kind.is_real else F64)
        return least(t, AGE) if key[0].endswith(CLOCK) else wrap(whole_of(t), kind.wraps)

    def get(self, place: Place) -> Any:
        """Return the value of a place."""
        value = self.store_of(place.leaf.root).read(place.leaf, self._index(place))
        if place.bit is None:
            return value
        number = self.subscript(place.bit, place.leaf.type.bits, place.text)
        return self.memory.bit_of(value, number)  # type: ignore[attr-defined]

    def put(self, place: Place, value: Any) -> None:
        """Set a place to a value of its type."""
        index, store = self._index(place), self.store_of(place.leaf.root)
        if place.bit is not None:
            number = self.subscript(place.bit, place.leaf.type.bits, place.text)
            word = store.read(place.leaf, index)
            value = self.memory.with_bit(word, number, value, place.leaf.type)  # type: ignore[attr-defined]
        store.write(place.leaf, index, value)

    def subscript(self, index: Resolved, length: Any, tag: str) -> Any:
        """Return a subscript or bit number below `length`, or fault."""
        value: Any = self.integer(index)
        if not isinstance(value, TermSymbol) and not isinstance(length, TermSymbol):
            if not 0 <= value < length:
                raise PathFault
            return value
        t, most = term_of(value, INT), term_of(length, INT)
        if self.paths.decide(or_(lt(t, const(0)), le(most, t))):
            raise PathFault
        return self.symbol(_below(t, most.hi))

    # --- conversions of rows

    def whole(self, value: Any) -> Any:
        """Return a number as a whole one, cut off, or a truth as 0 or 1."""
        if not isinstance(value, TermSymbol):
            return int(value)
        if value.t.kind in FLOATS:
            return self.symbol(self._cut(value.t))
        return self.symbol(term_of(value, INT))

    def truth(self, value: Any) -> Any:
        """Return whether a value is not 0."""
        return self.symbol(term_of(value, BOOL))

    def is_float(self, value: Any) -> bool:
        """Whether a number is REAL or LREAL."""
        return value.t.kind in FLOATS if isinstance(value, TermSymbol) else isinstance(value, float)

    def is_infinite(self, value: Any) -> Any:
        """Whether a number is infinite."""
        if not isinstance(value, TermSymbol) or value.t.kind not in FLOATS:
            return isinstance(value, float) and math.isinf(value)
        return self.symbol(and_(not_(is_finite(value.t)), not_(is_nan(value.t))))

    def is_nan(self, value: Any) -> Any:
        """Whether a number is NaN."""
        if not isinstance(value, TermSymbol) or value.t.kind not in FLOATS:
            return isinstance(value, float) and math.isnan(value)
        return self.symbol(is_nan(value.t))

    def infinity(self, value: Any) -> Any:
        """Return infinity with the sign of a number; that of a float of 0 and of NaN is unknown."""
        if not isinstance(value, TermSymbol):
            return super().infinity(value)
        t, zero = value.t, const(0) if value.t.kind == INT else const(0.0, value.t.kind)
        unsigned = FALSE if t.kind == INT else and_(not_(lt(t, zero)), not_(lt(zero, t)))
        below = ite(unsigned, self.unknown(BOOL), lt(t, zero)) if unsigned is not FALSE else lt(t, zero)
        return self.symbol(ite(below, const(-math.inf, F64), const(math.inf, F64)))

    def truncated(self, value: Any) -> Any:
        """Return a float without its fraction; 0 of infinity and NaN."""
        return self.symbol(self._cut(value.t)) if isinstance(value, TermSymbol) else super().truncated(value)

    def least(self, value: Any, most: int) -> Any:
        """Return the smaller of a number and a limit."""
        return self.symbol(least(term_of(value, INT), most))

    def converted(self, kind: Elementary, value: Any) -> Any:
        """Return a number converted to a type, without flags and faults."""
        if not isinstance(value, TermSymbol):
            return super().converted(kind, value)
        if kind.is_bool:
            return self.truth(value)
        if kind.is_real or kind.is_double:
            return self.symbol(to_float(value.t, F32 if kind.is_real else F64))
        if value.t.kind not in FLOATS:
            return self.symbol(wrap(whole_of(value.t), kind.wraps))
        return self.symbol(self._rounded_to(value.t, kind)[0])

    def copy(self, source: End, target: End, length: Any) -> None:
        """Copy bytes for `length` elements of the target, up to the end of either array."""
        self.regions.copy(source, target, length)

    def fill(self, target: End, length: Any, value: Any) -> None:
        """Set elements, up to the end of the array, each member to the value."""
        self.regions.fill(target, length, value)

    def take_bytes(self, store: Store, region: ArrayRegion, first: Any, count: Any) -> Any:
        """Return elements as bytes."""
        return self.regions.take(store, region, first, count)

    def put_bytes(self, store: Store, region: ArrayRegion, first: Any, count: Any, data: Any) -> None:
        """Set elements from bytes."""
        self.regions.put(store, region, first, count, data)

    def start_clock(self, since: Place) -> None:
        """Begin to measure the time in a hidden place."""
        self.put(since, 0)

    def elapsed(self, since: Place, unit_ns: int) -> Any:
        """Return the whole units of time since then; the rest stays."""
        age, unit = term_of(self.get(since), INT), const(unit_ns // 1_000_000)
        if unit.val == 1:
            self.put(since, 0)
            return self.symbol(age)
        rest = ite(eq(age, const(AGE)), self.unknown(INT, 0, unit.val - 1), rem(age, unit))
        self.put(since, self.symbol(rest))
        return self.symbol(div(age, unit))

    # --- what is unknown

    def unknown(self, kind: str, lo: int = 0, hi: int = 0) -> T:
        """Return a new variable for what is not modelled."""
        found = var(f"?{len(self.havocs)}", kind, lo, hi)
        self.havocs[found.val] = self.lowered.sites[self.site]
        return found

    def unknown_of(self, leaf: Leaf, site: Site | None = None) -> T:
        """Return a new variable for a leaf, with the instruction to blame, by default the current one."""
        is_clock = leaf.path.upper().endswith(CLOCK)
        found = self.unknown(*((INT, 0, AGE) if is_clock else kind_of(leaf.type)))
        if site is not None:
            self.havocs[found.val] = site
        return found

    # --- computing

    def rounded(self, value: Any, width: int) -> Any:
        """Return a number in the precision SINGLE or DOUBLE; unchanged for a width of integers."""
        if not isinstance(value, TermSymbol):
            return super().rounded(value, width)
        return value if width > 0 else self.symbol(to_float(value.t, F32 if width == SINGLE else F64))

    def _calculate(self, name: str, values: Sequence[Any], width: int) -> Any:
        if not any(isinstance(each, TermSymbol) for each in values):
            return super()._calculate(name, values, width)
        if width <= 0:
            return self.symbol(self._calculated_real(name, values, F32 if width == SINGLE else F64))
        terms = [term_of(each, INT) for each in values]
        if name in ("/", "MOD"):
            zero = eq(terms[1], const(0))
            self.fault_log.zero_divisor_if(zero)  # type: ignore[attr-defined]
            exact = _DIVISIONS[name](*terms)
            return self.symbol(ite(zero, terms[0], self._wrapped(exact, width, not_(zero))))
        return self.symbol(self._wrapped(self._exact(name, terms), width))

    def _exact(self, name: str, terms: Sequence[T]) -> T:
        if name not in _WHOLE:
            raise UnmodelledError(f"{name} of integers")
        return _WHOLE[name](*terms)

    def _wrapped(self, exact: T, width: int, guard: T = TRUE) -> T:
        """Return the low bits of a result; note an overflow where the guard holds."""
        result = wrap(exact, width)
        self.overflow_if(and_(guard, not_(eq(result, exact))))
        return result

    def _calculated_real(self, name: str, values: Sequence[Any], kind: str) -> T:
        terms = [term_of(each, kind) for each in values]
        if name == "/":
            self.fault_log.zero_divisor_if(not_(truth_of(terms[1])))  # type: ignore[attr-defined]
        if name == "MOD":
            self.fault_log.zero_divisor_if(not_(truth_of(terms[1])))  # type: ignore[attr-defined]
        result = self._real(name, terms, kind)
        if name not in ("NEG", "ABS"):
            finite = TRUE
            for each in terms:
                finite = and_(finite, is_finite(each))
            self.overflow_if(and_(finite, not_(is_finite(result))))
        return result

    def _real(self, name: str, terms: Sequence[T], kind: str) -> T:
        if name in _REAL:
            return _REAL[name](*terms)
        if name in _FACTORS:
            product = fop("fmul", to_float(terms[0], F64), const(_FACTORS[name], F64))
            return to_float(product, kind)
        if name in UNKNOWN:
            return self.unknown(kind)
        raise UnmodelledError(f"{name} of floating-point numbers")

    def overflow_if(self, t: T) -> None:
        """Note an overflow where a truth holds."""
        self.fault_log.overflow_if(t)  # type: ignore[attr-defined]

    def store(self, place: Place, value: Any) -> None:
        """Convert to the type of a place and set it."""
        kind = place.type
        if kind.is_bool:
            self.put(place, self.truth(value))
            return
        if not isinstance(value, TermSymbol):
            super().store(place, value)
            return
        stored = self.symbol(self._stored(value.t, kind))
        self.put(place, stored)
        self.set_flags(stored)

    def _stored(self, t: T, kind: Elementary) -> T:
        if kind.is_real or kind.is_double:
            found = to_float(t, F32 if kind.is_real else F64)
            if kind.is_real and t.kind == F64:
                self.overflow_if(and_(not_(is_finite(found)), is_finite(t)))
            return found
        if t.kind not in FLOATS:
            return self._wrapped(whole_of(t), kind.wraps)
        found, lost = self._rounded_to(t, kind)
        self.overflow_if(lost)
        return found

    def _rounded_to(self, t: T, kind: Elementary) -> tuple[T, T]:
        """Return a float as an integer of a type, and whether it does not fit.

        The low bits of a large REAL are 0; those of a large LREAL, and the upper ones of a large REAL as a
        LINT, are unknown.
        """
        exact = to_int(t, "rne")
        found = wrap(exact, kind.wraps)
        big = not_(and_(lt(t, const(_FAR, t.kind)), lt(const(-_FAR, t.kind), t)))
        lost = or_(big, not_(eq(found, exact)))
        if t.kind == F64 or kind.bits > 32:
            far = and_(big, is_finite(t))
            found = ite(far, self.unknown(*kind_of(kind)), found)
            lost = ite(far, self.unknown(BOOL), lost)
        return found, lost

    def _cut(self, t: T) -> T:
        """Return a float without its fraction, as a whole number; a large one is unknown."""
        big = not_(and_(lt(t, const(_FAR, t.kind)), lt(const(-_FAR, t.kind), t)))
        far = and_(big, is_finite(t))
        return ite(far, self.unknown(INT, -_LARGEST[t.kind], _LARGEST[t.kind]), to_int(t, "rtz"))

    # --- comparing

    def text(self, operand: Resolved) -> Any:
        """Return the characters of a string."""
        if not isinstance(operand, Group):
            return super().text(operand)
        store, layout, path, at = self.string(operand)
        data, counter = (layout.leaf(f"{path}.{name}") for name in ("DATA", "LEN"))
        room: int = data.dims[-1]
        codes = [term_of(store.read(data, at * room + number), INT) for number in range(room)]
        length = clip(term_of(store.read(counter, at), INT), 0, room)
        return TermText(self.symbol, length, [bitop("band", each, const(0xFF)) for each in codes])

    def set_text(self, target: Group, value: Any) -> None:
        """Set a string to characters, truncated to its size and padded with 0."""
        store, layout, path, at = self.string(target)
        data, counter = (layout.leaf(f"{path}.{name}") for name in ("DATA", "LEN"))
        room: int = data.dims[-1]
        text = TermText.of(self.symbol, value)
        length = least(text.length, room)
        store.write(counter, at, self.symbol(length))
        for number in range(room):
            code = ite(lt(const(number), length), wrap(text.at(number), data.type.wraps), const(0))
            store.write(data, at * room + number, self.symbol(code))

    def characters(self, name: str) -> Callable[..., Any]:
        """Return what a string instruction computes."""
        if name == "DTOS":
            return lambda _faults, _site, value: digits(self.symbol, self._nearest(value))
        if name == "STOD":
            return self._stod
        return super().characters(name)

    def _stod(self, _faults: Any, _site: int, text: Any, kind: Elementary, name: str) -> Any:
        """Return the first integer as a value of a type; None of an empty string."""
        if not text:
            return None
        exact, is_exact = number_in(TermText.of(self.symbol, text))
        if kind.is_integer:
            stored = term_of(self.converted(kind, self.symbol(exact)), INT)
            fit = and_(is_exact, eq(stored, exact))
        else:
            stored, fit = to_float(to_float(exact, F64), kind_of(kind)[0]), is_exact
        stored = ite(is_exact, stored, self.unknown(*kind_of(kind)))
        if not self.paths.decide(fit):
            self.fault_log.record(self.site, name, STRING_NUMBER_CODE)
        return self.symbol(stored)

    def bytes_of(self, value: Any, size: int) -> Any:
        """Return the low bytes of an integer, the lowest first, padded with 0."""
        if not isinstance(value, TermSymbol):
            return super().bytes_of(value, size)
        t = term_of(value, INT)
        return [*(Byte(t, at) for at in range(min(8, size))), *(Byte(const(0)) for _ in range(size - 8))]

    def integer_in(self, data: Any) -> Any:
        """Return the integer in bytes, the lowest first, without a sign."""
        if isinstance(data, bytes):
            return super().integer_in(data)
        data = [*data, *constant_bytes(bytes(8 - len(data)))]
        return self.symbol(unpack(data, 0, Field("", ULINT, 0), self.unknown))

    def _nearest(self, value: Any) -> Any:
        if self.is_float(value):
            raise UnmodelledError("the text of a floating-point number")
        return value

    def condition(self, condition: Resolved) -> Any:
        """Return the value of a condition; all parts are computed."""
        if not isinstance(condition, Calculation):
            return super().condition(condition)
        if condition.name in RELATIONS and not any(map(is_truth, condition.operands)):
            return self.compare(condition.name, *condition.operands)
        terms = [term_of(self.condition(each), BOOL) for each in condition.operands]
        return self.symbol(_TRUTH[condition.name](*terms))

    # --- paths

    def on_paths(self, run: Callable[[], Any]) -> T:
        """Run on every path; write what they write; return the truth of the result."""
        paths = self.paths.walk(run)
        for key in written_by(paths):
            old = self.state[key]
            now = merged(paths, lambda path, key=key, old=old: path.written.get(key, old))  # type: ignore[misc]
            self.state[key] = ite(self.active, now, old)
        bad = faults_of(paths)
        if bad is not FALSE:  # the scan ends there; here it goes on, which allows more
            self.faults.append((self.site, and_(self.active, bad)))
        return merged(paths, result_of)

    def here(self) -> T:
        """Return whether the current path is taken."""
        return and_(self.active, self.paths.here())


def _no_python(name: str, _inputs: object) -> Any:
    raise UnmodelledError(f"routine {name} in Python")


def _below(t: T, most: int) -> T:
    """Return a number that is below a limit, and not negative, with an interval that says so."""
    mask = (1 << max(0, most - 1).bit_length()) - 1
    return t if t.lo >= 0 and t.hi <= mask else bitop("band", t, const(mask))


def is_nan(t: T) -> T:
    """Return whether a float is no number."""
    return mk("fnan", (t,), BOOL)


def is_finite(t: T) -> T:
    """Return whether a float is neither infinite nor NaN."""
    return mk("ffin", (t,), BOOL)


def _absolute(t: T) -> T:
    return t if t.lo >= 0 else ite(lt(t, const(0)), sub(const(0), t), t)


_DIVISIONS = {"/": div, "MOD": rem}

_WHOLE: dict[str, Callable[..., T]] = {
    "+": add,
    "-": sub,
    "*": mul,
    "AND": lambda a, b: bitop("band", a, b),
    "OR": lambda a, b: bitop("bor", a, b),
    "XOR": lambda a, b: bitop("bxor", a, b),
    "NOT": inv,
    "NEG": lambda a: sub(const(0), a),
    "ABS": _absolute,
    "TRN": lambda a: a,
}


def _remainder(a: T, b: T) -> T:
    """Return the remainder with the sign of a."""
    size, divisor, zero = fop("fabs", a), fop("fabs", b), const(0.0, a.kind)
    near = fop("frem", size, divisor)
    found = ite(lt(near, zero), fop("fadd", near, divisor), near)
    return ite(lt(a, zero), fop("fneg", found), found)


def _truncated(t: T) -> T:
    """Return a float without its fraction; 0 of infinity and NaN."""
    whole = to_float(to_int(t, "rtz"), t.kind)
    big = not_(and_(lt(t, const(_FAR, t.kind)), lt(const(-_FAR, t.kind), t)))
    return ite(is_finite(t), ite(big, t, whole), const(0.0, t.kind))


_REAL: dict[str, Callable[..., T]] = {
    **{
        name: partial(fop, op)
        for name, op in {
            "+": "fadd",
            "-": "fsub",
            "*": "fmul",
            "/": "fdiv",
            "NEG": "fneg",
            "ABS": "fabs",
        }.items()
    },
    "MOD": _remainder,
    "SQR": lambda a: fop("fsqrt", fop("fabs", a)),
    "TRN": _truncated,
}

_FACTORS = {"DEG": 180 / math.pi, "RAD": math.pi / 180}

UNKNOWN = frozenset(("SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG", "**"))
"""Functions of floats whose result may be any number here."""

_TRUTH: dict[str, Callable[..., T]] = {
    "AND": and_,
    "OR": or_,
    "XOR": lambda a, b: not_(iff(a, b)),
    "NOT": not_,
    "=": iff,
    "<>": lambda a, b: not_(iff(a, b)),
    "<": lambda a, b: and_(not_(a), b),
    "<=": lambda a, b: or_(not_(a), b),
    ">": lambda a, b: and_(a, not_(b)),
    ">=": lambda a, b: or_(a, not_(b)),
}
