"""Services of the compiled program: functions for rare and slow operations."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..model import arithmetic
from ..model.errors import LadderFault
from ..model.operands import Resolved
from ..model.operators import CALLED
from ..model.spec import Use
from ..model.types import TYPES, Elementary
from ..state.characters import FUNCTIONS, read_string, store_string
from ..state.lowered import BROKEN, LoweredProgram, LoweredStep, parameters_of, passes_groups
from ..state.memory import NOTHING, CompiledAddOnStore, Passed, Store, Value, set_text_in, text_in
from ..state.regions import ArrayRegion, converted, copy, fill, region_of
from ..state.rows import copy_row, first_of, move_down, shift_bits, store_bytes
from ..state.tag_bytes import chars, set_chars

if TYPE_CHECKING:
    from ..run.engine import Engine


class Services:
    """Functions for one engine; their names are as in the compiled program."""

    def __init__(self, engine: Engine, interpreted: Mapping[int, LoweredStep]) -> None:
        self._engine = engine
        self._fault_log = engine.fault_log
        self._memory = engine.memory
        self._frames = engine.lowered.frames
        self._interpreted = interpreted

    def interpret(self, site: int, power: bool = True, frame: Mapping[str, Store] = NOTHING) -> bool:
        """Interpret an instruction; return the power after it. `frame` has stores by `Leaf.root`."""
        interpreter = self._engine.interpreter
        interpreter.now_ns, interpreter.frame = self._engine.now_ns, frame
        return interpreter.execute(self._interpreted[site], power)

    def fetched(self, site: int, *values: Any, frame: Mapping[str, Store] = NOTHING) -> Any:
        """Return the result of an instruction's `Spec.fetch`. `frame` has stores by `Leaf.root`."""
        interpreter, step = self._engine.interpreter, self._interpreted[site]
        assert step.spec.fetch is not None
        interpreter.now_ns, interpreter.site, interpreter.frame = self._engine.now_ns, site, frame
        return step.spec.fetch(interpreter, *values, *step.operands)

    def passed(self, site: int, number: int) -> Passed:
        """Return a structure or an array that an instruction passes, as bytes."""
        interpreter = self._engine.interpreter
        interpreter.frame, interpreter.site = NOTHING, site
        return interpreter.value(parameters_of(self._interpreted[site])[0][number])

    def received(self, site: int, number: int, value: Passed) -> None:
        """Set a structure or an array from a parameter."""
        interpreter = self._engine.interpreter
        interpreter.frame, interpreter.site = NOTHING, site
        interpreter.take(parameters_of(self._interpreted[site])[1][number : number + 1], (value,))

    def subscript(self, index: int, length: int, site: int, tag: str) -> int:
        """Return an index that is in range; fault on any other index."""
        if not 0 <= index < length:
            self._fault_log.subscript(site, tag, index, length)
        return index

    def outside(self, index: int, length: int, site: int, tag: str) -> int:
        """Fault on an out-of-range subscript."""
        self._fault_log.subscript(site, tag, index, length)

    def negative(self, site: int, tag: str, preset: int, accumulated: int) -> None:
        """Fault if PRE or ACC of a timer is negative."""
        if preset < 0 or accumulated < 0:
            self._fault_log.negative_timer(site, tag, preset, accumulated)

    def narrow(self, site: int, value: int, width: int, bits: int) -> int:
        """Wrap a number to the width of the computation, then to the width of the tag."""
        result = arithmetic.wrap(arithmetic.wrap(value, width), bits)
        if result != value:
            self._fault_log.overflow(site)
        return result

    def integer(self, site: int, value: float, bits: int) -> int:
        """Convert a REAL to an integer."""
        exact = arithmetic.whole(value)
        result = arithmetic.wrap(exact, bits)
        if result != exact or not arithmetic.finite(value):
            self._fault_log.overflow(site)
        return result

    def cut(self, site: int, value: float) -> int:
        """Truncate a REAL."""
        if not arithmetic.finite(value):
            self._fault_log.overflow(site)
        return arithmetic.truncated(value)

    def divide(self, site: int, a: int, b: int) -> int:
        """Divide integers; a divisor of 0 yields the dividend."""
        if b == 0:
            self._fault_log.zero_divisor(site)
            return a
        return arithmetic.quotient(a, b)

    def modulo(self, site: int, a: int, b: int) -> int:
        """Return the remainder of integers; a divisor of 0 yields the dividend."""
        if b == 0:
            self._fault_log.zero_divisor(site)
            return a
        return arithmetic.remainder(a, b)

    def real_result(self, site: int, value: float, *operands: float) -> float:
        """Round a REAL result; record a fault if the result is not finite but its operands are."""
        result = arithmetic.real(value)
        if result - result != 0.0 and all(map(arithmetic.finite, operands)):  # faster than a call of `finite`
            self._fault_log.overflow(site)
        return result

    def real_divide(self, site: int, a: float, b: float) -> float:
        """Divide REAL values."""
        if b == 0:
            self._fault_log.zero_divisor(site)
        return self.real_result(site, arithmetic.real_quotient(a, b), a, b)

    def real_modulo(self, site: int, a: float, b: float) -> float:
        """Return the remainder of REAL values."""
        if b == 0:
            self._fault_log.zero_divisor(site)
        return self.real_result(site, arithmetic.real_remainder(a, b), a, b)

    def double_result(self, site: int, value: float, *operands: float) -> float:
        """Return an LREAL result; record a fault if it is not finite but its operands are."""
        if not arithmetic.finite(value) and all(map(arithmetic.finite, operands)):
            self._fault_log.overflow(site)
        return value

    def double_divide(self, site: int, a: float, b: float) -> float:
        """Divide LREAL values."""
        if b == 0:
            self._fault_log.zero_divisor(site)
        return self.double_result(site, arithmetic.real_quotient(a, b), a, b)

    def double_modulo(self, site: int, a: float, b: float) -> float:
        """Return the remainder of LREAL values."""
        if b == 0:
            self._fault_log.zero_divisor(site)
        return self.double_result(site, arithmetic.real_remainder(a, b), a, b)

    def copy(
        self,
        source: ArrayRegion,
        first: int,
        target: ArrayRegion,
        target_first: int,
        length: int,
        origin: Store | None = None,
        goal: Store | None = None,
    ) -> None:
        """Copy bytes between regions; a region without a store is in the program's memory."""
        copy((origin or self._memory, source, first), (goal or self._memory, target, target_first), length)

    def fill(
        self, target: ArrayRegion, first: int, length: int, value: Value, goal: Store | None = None
    ) -> None:
        """Fill elements with a converted value."""
        fill((goal or self._memory, target, first), length, value)

    def stretch(
        self, frame: str, values: Any, base: int = 0, left: int = 1, mask: int | None = None
    ) -> CompiledAddOnStore:
        """Return an instance or an argument as a store."""
        return CompiledAddOnStore(self._frames[frame].layout, values, base, left, mask)

    def mask(self, bit: int, bits: int, signed: bool) -> int:
        """Return the integer with only this bit set."""
        return -1 << bit if signed and bit == bits - 1 else 1 << bit

    def text_in(self, store: Store, frame: str, path: str, index: int) -> bytes:
        """Return the characters of a string of an add-on instruction."""
        return text_in(store, self._frames[frame].layout, path, index)

    def set_text_in(self, store: Store, frame: str, path: str, index: int, value: bytes) -> None:
        """Set a string of an add-on instruction to characters."""
        set_text_in(store, self._frames[frame].layout, path, index, value)

    def answer(self, site: int, value: Value, kind: str) -> Value:
        """Convert a parameter or a returned value to its tag's type."""
        if kind == "REAL":
            return self.real_result(site, value, value)
        if kind == "LREAL":
            return float(value)
        target = TYPES[kind]
        assert isinstance(target, Elementary)
        bits = target.wraps
        if isinstance(value, float):
            return self.integer(site, value, bits)
        return self.narrow(site, int(value), 64, bits)


def interpreted_of(lowered: LoweredProgram) -> dict[int, LoweredStep]:
    """Return, by site, the instructions that are interpreted or that pass strings or structures."""
    return {
        step.site: step
        for step in lowered.all_steps
        if step.spec.write is None
        or step.spec.partly
        or Use.TEXT in step.uses
        or Use.TEXT_TARGET in step.uses
        or passes_groups(step)
    }


_NAMES = tuple(name for name in dir(Services) if not name.startswith("_"))


def services(engine: Engine, regions: Regions, interpreted: Mapping[int, LoweredStep]) -> dict[str, Any]:
    """Return the compiled program's environment by name, from `regions_of` and `interpreted_of`."""
    provided = Services(engine, interpreted)
    environment = {name: getattr(provided, name) for name in _NAMES}
    log, memory = engine.fault_log, engine.memory
    environment |= {"called": log.called, "returned": log.returned, "jumped_back": log.jumped_back}
    environment |= {"negative_control": log.negative_control, "python": engine.call_python}
    environment |= {"text": memory.text, "set_text": memory.set_text}
    environment["region"], environment["site"] = regions, engine.lowered.sites
    environment["LadderFault"] = LadderFault
    if engine.scheduler is not None:
        environment["rung_done"] = engine.scheduler.rung_done
    environment |= {"array": array, "chars": chars, "set_chars": set_chars, "faults": log}
    environment |= {"read_string": read_string, "store_string": store_string, "types": TYPES}
    environment |= {f"string_{name}": function for name, function in FUNCTIONS.items()}
    environment |= {
        service.__name__: service for service in (copy_row, first_of, move_down, shift_bits, store_bytes)
    }
    environment |= {"broken": BROKEN, "converted": converted}
    return environment | CALLED


class Regions(dict[tuple[int, int], ArrayRegion]):
    """Regions of copy and fill instructions by site and operand, computed on first use."""

    def __init__(self, operands: Mapping[tuple[int, int], Resolved]) -> None:
        self._operands = operands

    def __missing__(self, key: tuple[int, int]) -> ArrayRegion:
        region = self[key] = region_of(self._operands[key])
        return region


def regions_of(lowered: LoweredProgram) -> Regions:
    """Return the regions of a program."""
    return Regions(
        {
            (step.site, number): operand
            for step in lowered.all_steps
            for number, (use, operand) in enumerate(zip(step.uses, step.operands, strict=False))
            if use in (Use.SOURCE, Use.DESTINATION)
        }
    )
