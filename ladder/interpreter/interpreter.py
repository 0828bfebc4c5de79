"""The interpreter: executes the lowered tree plainly. It is slow, and it is what the compiler has to equal.

Power flows from left to right. An input that is reached with power decides whether
there is power behind it; an output that is reached acts. Every instruction is one
short method, in the words of the manual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ..errors import LadderFault
from ..fault_log import FaultLog
from ..instructions import Kind
from ..lowered import ADD_ON, AddOnCall, Call, Line, Lowered, LoweredRoutine, Node, Parallel, Step
from ..memory import Memory, Value
from ..operands import Constant, Group, Place, Resolved
from ..tags import OVERRIDE
from .bits import BitInstructions
from .files import FileInstructions
from .numbers import COMPARISONS, COMPUTATIONS, NumberInstructions
from .timing import TimeInstructions
from .values import place_of

Caller = Callable[[str, Sequence[Value]], Sequence[Value]]
"""Calls a routine in Python: name in capitals, values in; returns the values out."""


class _Jump(Exception):  # noqa: N818 - control flow, not an error
    def __init__(self, label: str, site: int) -> None:
        self.label, self.site = label, site


class _Return(Exception):  # noqa: N818
    def __init__(self, values: tuple[Value, ...]) -> None:
        self.values = values


class Interpreter(BitInstructions, TimeInstructions, NumberInstructions, FileInstructions):
    """Runs a lowered program on a memory.

    Args:
        lowered: the program.
        memory: its memory.
        fault_log: collects its faults.
        call_python: calls routines in Python.
    """

    def __init__(self, lowered: Lowered, memory: Memory, fault_log: FaultLog, call_python: Caller) -> None:
        super().__init__(lowered, memory, fault_log)
        self._call_python = call_python

    def scan(self, now_ns: int) -> None:
        """Run the main routine once.

        Raises:
            LadderFault: a major fault.
        """
        self._now = now_ns
        if self._lowered.override:
            self._set_leaf(OVERRIDE, False)
        self.run(self._lowered.main, ())

    def run(self, name: str, inputs: Sequence[Value]) -> tuple[Value, ...]:
        """Run a routine; return what it returns."""
        if name in self._lowered.functions:
            return tuple(self._call_python(name, inputs))
        routine = self._lowered.routines[name]
        try:
            self._lines(routine, inputs)
        except _Return as back:
            return back.values
        return ()

    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Value]) -> None:
        number = 0
        while number < len(routine.lines):
            try:
                self._line(routine.lines[number], inputs)
                number += 1
            except _Jump as jump:
                target = routine.labels[jump.label]
                if target <= number:
                    self._fault_log.jumped_back(jump.site)
                number = target

    def _line(self, line: Line, inputs: Sequence[Value]) -> None:
        power = not (self._lowered.override and self._leaf(OVERRIDE))
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
        """Copy in; if the rung has a routine for its state, run it and copy out [1756-PM010]."""
        for series in call.inputs:
            self._series(series, True)
        self.put(call.enable_in, power)
        self.put(call.enable_out, power)
        routine = call.logic if power else call.otherwise
        if routine is None:
            return False
        inputs = self._inputs
        self.run(routine, ())
        self._inputs = inputs
        for series in call.outputs:
            self._series(series, True)
        return bool(self.get(call.enable_out))

    # --- program control

    def _jmp(self, label: str) -> None:
        raise _Jump(label, self._site)

    def _jsr(self, call: Call) -> None:
        site, inputs = self._site, self._inputs
        values = [self._value(each) for each in call.inputs]
        answers = self.run(call.routine, values)
        self._site, self._inputs = site, inputs
        for place, value in zip(call.returns, answers, strict=False):
            self._before()
            self._store(place, value)

    def _value(self, operand: Resolved) -> Value:
        return operand.value if isinstance(operand, Constant) else self.get(place_of(operand))

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
        routine = self._lowered.routines.get(self._lowered.main if name is None else name)
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
        """Copy in, prescan Logic, run Prescan, copy out [1756-PM010]."""
        self._pass_in_prescan(call.inputs)
        self.put(call.enable_in, False)
        self.put(call.enable_out, False)
        self.prescan(call.logic)
        if call.prescan is not None:
            self._inputs = ()
            self.run(call.prescan, ())
        self._pass_in_prescan(call.outputs)

    def _pass_in_prescan(self, copies: tuple[tuple[Node, ...], ...]) -> None:
        """Copy parameters; one whose subscript is out of range stays, see `_prescan_step`."""
        for series in copies:
            try:
                self._series(series, True)
            except LadderFault:
                continue

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
