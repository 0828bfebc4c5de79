"""Common parts of the process control function blocks [1756-RM006K, Function Block Attributes].

| | |
|---|---|
| status | `wrong` notes each fault; its bit, InstructFault and Status show it after the call |
| EnableOut | false if Out, or another result, is infinite or NaN |
| DeltaT | by TimingMode: the task's period, or whole ms since the last call; OversampleDT; time stamps |
| control | Program or Operator control by four requests; ProgOperReq and ProgProgReq have precedence |
| first run, first scan | `ran` is false only before the first call, `begun` is false after each prescan |
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from functools import cache, partial
from typing import Any

from ...compiler.blocks import names_of, write_block
from ...interpreter import Interpreter
from ...interpreter.files import Elements, Members
from ...model.arithmetic import real
from ...model.operand_checks import OperandError, require_type
from ...model.operands import Group, Place, Resolved
from ...model.predefined.block_types import BLOCK_TYPES, BLOCKS
from ...model.predefined.process_types import ARRAYS, STATUS_BITS
from ...model.spec import Spec, Use, action
from ...model.types import REAL, Structure
from ...state.regions import converted
from ..prescans import prescan_sets

NS_PER_MS = 1_000_000
NS_PER_S = 1000 * NS_PER_MS
MS_PER_S = 1000
STAMPS = 1 << 15
"""Time stamps run from 0 to 32,767 ms."""

MOST_OVERSAMPLE_S = 4194.303


class FunctionBlock(Members):
    """A block during a call: `block["In"]`, `block.set(Out=1.0)`.

    Attributes:
        new: whether this is the first call after power-up; False for a block without control modes.
        first: whether this is the first call after a prescan; False for a block without such a bit.
        elapsed_ms: whole ms since the last call, 0 in the first scan; the remainder counts in the next call.
        delta_t: DeltaT in seconds, 0 if the algorithm does not run.
    """

    def __init__(self, machine: Interpreter, group: Group, arrays: tuple[Resolved, ...] = ()) -> None:
        super().__init__(machine, group)
        self.machine: Interpreter = machine
        self.arrays = tuple(Elements(machine, array) for array in arrays)
        self.new = self.first = False
        self.elapsed_ms, self.delta_t = 0, 0.0
        self._faults: dict[str, bool] = {}

    def real(self, name: str) -> float:
        """Return a member as a number."""
        return float(self[name])

    def rounded(self, value: float) -> float:
        """Return a number rounded to REAL; infinite if it is too large."""
        return float(self.machine.converted(REAL, value))

    def on(self, name: str) -> bool:
        """Return whether a member is set."""
        return bool(self[name])

    def wrong(self, **faults: bool) -> bool:
        """Note faults by the names of their bits; return whether any is true."""
        flags = {name: bool(fault) for name, fault in faults.items()}
        self._faults.update(flags)
        return any(flags.values())

    def limited(self, name: str, low: float, high: float, fault: str = "") -> float:
        """Return an input limited to a range; if it is outside, note `fault`, by default its `Inv` bit."""
        value = self.real(name)
        inside = low <= value <= high
        self.wrong(**{fault or f"{name}Inv": not inside})
        if inside:
            return value
        return high if value > high else low  # NaN becomes `low`

    def forbids(self, change: float, high: str = "HoldHigh", low: str = "HoldLow") -> bool:
        """Return whether a bit prevents a change: `high` prevents an increase, `low` a decrease."""
        return (change > 0 and self.on(high)) or (change < 0 and self.on(low))

    def report(self, bits: dict[str, tuple[str, int]]) -> None:
        """Set the status words and their bits; each bit is given by its word and bit number."""
        faults = {name: self._faults.get(name, False) for name in bits}
        faults["InstructFault"] = any(self._faults.values())
        words = dict.fromkeys((word for word, _ in bits.values()), 0)
        for name, (word, bit) in bits.items():
            words[word] |= int(faults[name]) << bit
        self.set(**faults, **{word: value - (value >> 31 << 32) for word, value in words.items()})

    # --- the beginning of a call

    def begin(self, names: Container[str]) -> None:
        """Set the attributes, and record that the block has run.

        The first run starts in Operator control. The first scan ignores all earlier requests.

        Args:
            names: the names of the block's members.
        """
        if "~ran" in names:
            self.new = self._set_first_time("~ran")
        if self.new:
            self.set(ProgOper=False)
        if "~begun" in names:
            self.first = self._set_first_time("~begun")
        if "~ran" in names and self.first:
            self.clear_requests()
        if "~last_ns" in names:
            self.elapsed_ms = self._measure_ms()
        if "TimingMode" in names:
            self.delta_t = self._measure_delta_t()

    def _set_first_time(self, name: str) -> bool:
        """Set a hidden bit; return whether it was off before."""
        was_off = not self.on(name)
        self.set(**{name: True})
        return was_off

    def _measure_ms(self) -> int:
        """Return the whole ms since the last call, and keep the remainder; 0 in the first scan."""
        since = self._group.member("~last_ns")
        if self.first:
            self.machine.start_clock(since)
            return 0
        return self.machine.elapsed(since, NS_PER_MS)

    def _measure_delta_t(self) -> float:
        """Set DeltaT according to the timing mode; return it, or 0 if the algorithm does not run."""
        mode = self["TimingMode"]
        elapsed = self.elapsed_ms / MS_PER_S
        scheduler = self.machine.scheduler
        if mode == 1:
            elapsed = self.real("OversampleDT")
            if self.wrong(DeltaTInv=not 0 <= elapsed <= MOST_OVERSAMPLE_S):
                elapsed = 0.0
        elif mode == 2:
            elapsed = self._sampled()
        elif self.wrong(TimingModeInv=mode != 0):
            elapsed = 0.0
        elif scheduler is not None and scheduler.period_ns:
            elapsed = scheduler.period_ns / NS_PER_S
        self.set(DeltaT=elapsed)
        return elapsed

    def _sampled(self) -> float:
        """Return the seconds between the time stamps of two samples."""
        stamp, period = int(self["RTSTimeStamp"]), int(self["RTSTime"])
        unusable = self.wrong(RTSTimeInv=not 1 <= period < STAMPS)
        if self.wrong(RTSTimeStampInv=not 0 <= stamp < STAMPS):
            return 0.0
        elapsed = 0 if self.first else (stamp - int(self["~stamp"])) % STAMPS
        self.set(**{"~stamp": stamp})
        self.wrong(RTSMissed=not self.first and not unusable and abs(elapsed - period) > 1)
        return elapsed / MS_PER_S

    # --- control

    def control(self) -> bool:
        """Set ProgOper according to the first active request; return whether the program has control."""
        program = self.on("ProgOper")
        for request in ("ProgOperReq", "ProgProgReq", "OperOperReq", "OperProgReq"):
            if self.on(request):
                program = request.endswith("ProgReq")
                break
        self.set(ProgOper=program)
        return program

    def clear_requests(self) -> None:
        """Clear the operator's requests, and with ProgValueReset also the program's."""
        sides = ("Oper", "Prog") if self.on("ProgValueReset") else ("Oper",)
        self.set(**dict.fromkeys(_requests(self._group.type.name, sides), False))


@cache
def _requests(kind: str, sides: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of a block's request inputs for these sides, such as `OperAutoReq`."""
    names = [member.name for member in BLOCK_TYPES[kind].members if member.name.endswith("Req")]
    return tuple(name for name in names if name.startswith(sides))


Converters = dict[str, Callable[[Any], Any]]


class CompiledBlock(FunctionBlock):
    """A block in a compiled program. The program passes all members of the block as values."""

    def __init__(
        self,
        machine: Interpreter,
        group: Group,
        arrays: tuple[Resolved, ...],
        values: dict[str, Any],
        converters: Converters,
    ) -> None:
        super().__init__(machine, group, arrays)
        self.values, self._converters = values, converters

    def __getitem__(self, name: str) -> Any:
        """Return a member."""
        return self.values[name]

    def set(self, **members: Any) -> None:
        """Set members."""
        values, converters = self.values, self._converters
        for name, value in members.items():
            values[name] = converters[name](value)

    def _measure_ms(self) -> int:
        """Return the whole ms since the last call, from the passed values; 0 in the first scan."""
        now, last = self.machine.now_ns, self.values["~last_ns"]
        elapsed = 0 if self.first else (now - last) // NS_PER_MS
        self.values["~last_ns"] = now if self.first else last + elapsed * NS_PER_MS
        return elapsed


def _converter(kind: Any) -> Callable[[Any], Any]:
    """Return a function that converts a number to a type, as `converted` does."""
    direct: dict[str, Callable[[Any], Any]] = {"BOOL": bool, "REAL": real, "LREAL": float}
    return direct.get(kind.name) or partial(converted, kind)


def _check_arrays(block: Group, *arrays: Resolved, kind: Structure) -> None:
    """Raise an OperandError unless the block is of the given type, and each array of REAL."""
    require_type(block, kind)
    for array in arrays:
        if not isinstance(array, Place | Group) or array.type != REAL:
            raise OperandError(
                f"{getattr(array, 'text', array)} is not an array of REAL", "pass an array of REAL"
            )


def block_row(name: str, step: Callable[[FunctionBlock], Any], *, optional: int = 0) -> Spec:
    """Return the row of a block.

    Args:
        name: the name in `BLOCKS`.
        step: runs one call; returns a result that can overflow, or None.
        optional: number of trailing arrays that can be omitted.
    """
    kind = BLOCKS[name]
    arrays = ARRAYS.get(name, ())
    bits = STATUS_BITS[kind.name]
    names = names_of(kind)
    types = [*kind.members, *kind.hidden]
    converters = {name: _converter(member_type.type) for name, member_type in zip(names, types, strict=True)}

    def call(block: FunctionBlock) -> None:
        """Set the block's attributes, run its step, and set EnableOut and the status words."""
        block.begin(converters)
        result, machine = step(block), block.machine
        if "~ran" in converters:
            block.clear_requests()
        block.set(EnableOut=result is None or not (machine.is_infinite(result) or machine.is_nan(result)))
        if bits:
            block.report(bits)

    def run(machine: Interpreter, group: Group, *arrays_given: Resolved) -> None:
        call(FunctionBlock(machine, group, arrays_given))

    def fetch(
        machine: Interpreter, values: Iterable[Any], group: Group, *arrays_given: Resolved
    ) -> tuple[Any, ...]:
        """Run one call in a compiled program; return all members of the block, in the order of `values`."""
        block = CompiledBlock(machine, group, arrays_given, dict(zip(names, values, strict=True)), converters)
        call(block)
        return tuple(block.values.values())

    initial = {"~begun": False, "~before": True}  # a clock that is on in the first scan is not a rising edge
    return action(
        name,
        Use.BLOCK,
        *[Use.ARRAY] * len(arrays),
        optional=optional,
        run=run,
        write=write_block,
        fetch=fetch,
        partly=True,
        faults=bool(arrays),
        prescan=prescan_sets(0, **{name: initial[name] for name in names if name in initial}),
        check=partial(_check_arrays, kind=kind),
        in_rungs=False,
    )
