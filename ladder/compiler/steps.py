"""Rungs as Python: how power runs through series and branches, and what each instruction becomes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..instructions import Kind
from ..interpreter import COMPARISONS, COMPUTATIONS, MS, width_of
from ..linking import ADD_ON, AddOnCall, Call, Node, Parallel, Step
from ..places import Calculation, Constant, Group, Place, Resolved, can_fault
from ..regions import Region, plain, region_of
from ..tags import OVERRIDE
from ..types import DINT, LINT
from .values import Term, Values
from .writer import Writer


class RungWriter:
    """Writes the rungs of one routine.

    Attributes:
        override: variable of the override that MCR toggles.
        sections: number of the section that a label starts.
    """

    def __init__(self, writer: Writer, functions: dict[str, str]) -> None:
        self.writer = writer
        self.values = Values(writer)
        self.sections: dict[str, int] = {}
        self._functions = functions
        self._override = writer.linked.layout.leaf(OVERRIDE)
        self.override = self._override.ident

    def set_override(self, text: str) -> None:
        """Write a line that sets the override."""
        self.writer.assigned(self._override)
        self.writer.line(f"{self.override} = {text}")

    # --- power

    def series(self, nodes: tuple[Node, ...], power: str, *, needed: bool) -> str:
        """Write a series; return the power behind it, which means nothing unless `needed`."""
        for number, node in enumerate(nodes):
            rest = nodes[number + 1 :]
            if isinstance(node, Parallel):
                power = self._branch(node, power, needed=needed or bool(rest))
            elif not needed and all(map(_acts_when_true, nodes[number:])):
                self._outputs(nodes[number:], power)
                return power
            else:
                power = self._step(node, power, needed=needed or bool(rest))
        return power

    def _branch(self, branch: Parallel, power: str, *, needed: bool) -> str:
        if all(_is_inline(node, safe=True) for leg in branch.legs for node in leg):
            legs = [self.series(leg, "True", needed=True) for leg in branch.legs]
            return _and(power, _or(legs))
        power = self._kept(power)
        behind = []
        for leg in branch.legs:
            out = self.series(leg, power, needed=needed)
            if needed:
                behind.append(out if out == power else self._kept(out))
        return power if not needed or power in behind else _or(behind)

    def _kept(self, power: str) -> str:
        return power if power in ("True", "False") else self.values.keep(power)

    def _outputs(self, nodes: Iterable[Node], power: str) -> None:
        """Write instructions that act when true, under one condition."""
        if power == "True":
            for node in nodes:
                self._act(node)
            return
        with self.writer.block(f"if {power}:"):
            for node in nodes:
                self._act(node)

    def _act(self, node: Node) -> None:
        assert isinstance(node, Step)
        self.values.site = node.site
        _OUTPUTS[node.name](self, *node.operands)

    def _step(self, step: Step, power: str, *, needed: bool) -> str:
        self.values.site = step.site
        if step.kind is Kind.INPUT:
            return self._input(step, power)
        if step.name == ADD_ON:
            return self._add_on(power, step.operands[0])
        if needed:
            power = self._kept(power)
        if step.kind is Kind.OUTPUT:
            self._outputs((step,), power)
        else:
            _BOTH[step.name](self, power, *step.operands)
        return power

    def _input(self, step: Step, power: str) -> str:
        if step.name == "ONS":
            return self._one_shot(power, step.operands[0])
        if step.name == "SBR":
            self._parameters(power, step.operands)
            return power
        if _is_inline(step):
            return _and(power, _INPUTS[step.name](self, *step.operands))
        if power == "True":
            return self.values.keep(_INPUTS[step.name](self, *step.operands))
        result = self.values.keep("False")
        with self.writer.block(f"if {power}:"):
            self.writer.line(f"{result} = {_INPUTS[step.name](self, *step.operands)}")
        return result

    def _either(self, power: str, when_true: Callable[[], None], when_false: Callable[[], None]) -> None:
        """Write what an instruction does on a true rung and on a false one."""
        if power == "True":
            when_true()
        elif power == "False":
            when_false()
        else:
            with self.writer.block(f"if {power}:"):
                when_true()
            with self.writer.block("else:"):
                when_false()

    # --- bit instructions

    def _one_shot(self, power: str, storage: Place) -> str:
        power = self._kept(power)
        passes = self.values.keep(_and(power, f"not {self.values.read(storage)}"))
        self.values.set_bit(storage, power)
        return passes

    def _xic(self, bit: Place) -> str:
        return self.values.read(bit)

    def _xio(self, bit: Place) -> str:
        return f"not {self.values.read(bit)}"

    def _ote(self, power: str, bit: Place) -> None:
        if bit.bit is not None or bit.leaf.dims:
            power = self._kept(power)
        self.values.set_bit(bit, power)

    def _osr(self, power: str, storage: Place, output: Place) -> None:
        power = self._kept(power)
        before = self.values.keep(self.values.read(storage))
        self.values.set_bit(storage, power)
        self.values.set_bit(output, self._kept(_and(power, f"not {before}")))

    def _osf(self, power: str, storage: Place, output: Place) -> None:
        power = self._kept(power)
        before = self.values.keep(self.values.read(storage))
        self.values.set_bit(storage, power)
        self.values.set_bit(output, self._kept(_and(before, f"not {power}")))

    # --- timers and counters

    def _set(self, structure: Group, **members: str) -> None:
        for name, text in members.items():
            self.values.assign(structure.member(name), text)

    def _get(self, structure: Group, name: str) -> str:
        return self.values.read(structure.member(name))

    def _start(self, timer: Group) -> None:
        self.values.assign(timer.member("~last_ns"), "now")

    def _add_time(self, timer: Group) -> None:
        last, accumulated = self._get(timer, "~last_ns"), self._get(timer, "ACC")
        elapsed = self.values.keep(f"(now - {last}) // {MS}")
        with self.writer.block(f"if {elapsed}:"):
            self.values.assign(timer.member("~last_ns"), f"{last} + {elapsed} * {MS}")
            self.values.assign(timer.member("ACC"), f"min({accumulated} + {elapsed}, {DINT.highest})")

    def _reached(self, timer: Group, **done: str) -> None:
        preset, accumulated = self._get(timer, "PRE"), self._get(timer, "ACC")
        with self.writer.block(f"if 0 <= {accumulated} < {preset}:"):
            self._set(timer, TT="True")
        with self.writer.block("else:"):
            self.writer.line(f"negative({self.values.site}, {timer.text!r}, {preset}, {accumulated})")
            self._set(timer, **done)

    def _time_on(self, timer: Group) -> None:
        with self.writer.block(f"if not {self._get(timer, 'DN')}:"):
            with self.writer.block(f"if {self._get(timer, 'EN')}:"):
                self._add_time(timer)
            with self.writer.block("else:"):
                self._start(timer)
            self._reached(timer, TT="False", DN="True")
        with self.writer.block("else:"):
            self._set(timer, TT="False")
        self._set(timer, EN="True")

    def _ton(self, power: str, timer: Group) -> None:
        self._either(
            power,
            lambda: self._time_on(timer),
            lambda: self._set(timer, EN="False", TT="False", DN="False", ACC="0"),
        )

    def _rto(self, power: str, timer: Group) -> None:
        self._either(power, lambda: self._time_on(timer), lambda: self._set(timer, EN="False", TT="False"))

    def _tof(self, power: str, timer: Group) -> None:
        self._either(
            power,
            lambda: self._set(timer, EN="True", TT="False", DN="True", ACC="0"),
            lambda: self._time_off(timer),
        )

    def _time_off(self, timer: Group) -> None:
        with self.writer.block(f"if {self._get(timer, 'DN')}:"):
            with self.writer.block(f"if {self._get(timer, 'EN')}:"):
                self._start(timer)
            with self.writer.block("else:"):
                self._add_time(timer)
            self._reached(timer, TT="False", DN="False")
        with self.writer.block("else:"):
            self._set(timer, TT="False")
        self._set(timer, EN="False")

    def _ctu(self, power: str, counter: Group) -> None:
        self._count(power, counter, "CU", DINT.highest, DINT.lowest, "+ 1", "UN", "OV")

    def _ctd(self, power: str, counter: Group) -> None:
        self._count(power, counter, "CD", DINT.lowest, DINT.highest, "- 1", "OV", "UN")

    def _count(
        self,
        power: str,
        counter: Group,
        enable: str,
        last: int,
        wrapped: int,
        step: str,
        back: str,
        beyond: str,
    ) -> None:
        def when_true() -> None:
            accumulated = self._get(counter, "ACC")
            with self.writer.block(f"if not {self._get(counter, enable)}:"):
                self._set(counter, **{enable: "True"})
                with self.writer.block(f"if {accumulated} != {last}:"):
                    self._set(counter, ACC=f"{accumulated} {step}")
                with self.writer.block("else:"):
                    self._set(counter, ACC=str(wrapped))
                    with self.writer.block(f"if {self._get(counter, back)}:"):
                        self._set(counter, **{back: "False"})
                    with self.writer.block("else:"):
                        self._set(counter, **{beyond: "True"})
            reached = f"{accumulated} >= {self._get(counter, 'PRE')}"
            over, under = self._get(counter, "OV"), self._get(counter, "UN")
            self._set(counter, DN=f"{over} or {reached} and not {under}")

        self._either(power, when_true, lambda: self._set(counter, **{enable: "False"}))

    def _res(self, structure: Group) -> None:
        kind: Any = structure.type
        for member in kind.members:
            if member.name not in ("PRE", "LEN"):
                self.values.assign(structure.member(member.name), repr(member.type.zero))

    # --- compare

    def _lim(self, low: Resolved, test: Resolved, high: Resolved) -> str:
        width = width_of(low, test, high)
        texts = [self.values.term(each, width).text for each in (low, test, high)]
        if any(map(can_fault, (low, test, high))):
            texts = [self.values.keep(text) for text in texts]
        least, value, most = texts
        if isinstance(low, Constant) and isinstance(high, Constant) and low.value <= high.value:
            return f"({least} <= {value} <= {most})"
        return (
            f"({least} <= {value} <= {most} if {least} <= {most} else "
            f"{value} >= {least} or {value} <= {most})"
        )

    def _meq(self, source: Resolved, mask: Resolved, compare: Resolved) -> str:
        texts = [self.values.filled(each, LINT.bits) for each in (source, mask, compare)]
        return f"(({texts[0]} ^ {texts[2]}) & {texts[1]} == 0)"

    # --- compute, move and logical

    def _compute(self, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
        self.values.before()
        width = width_of(*operands, target)
        if self.writer.flags and width and name in ("+", "-", "NEG"):
            self._carry(name, operands, width)
        terms = [self.values.term(each, width) for each in operands]
        operation = self.values.operation if width else self.values.real_operation
        term = operation(name, terms)
        self.values.store(target, term, width)

    def _carry(self, name: str, operands: tuple[Resolved, ...], width: int) -> None:
        mask = (1 << width) - 1
        texts = [f"({self.values.term(each, width).text} & {mask})" for each in operands]
        self.values.set_flag(
            "S:C",
            {
                "+": f"{texts[0]} + {texts[-1]} > {mask}",
                "-": f"{texts[0]} < {texts[-1]}",
                "NEG": f"{texts[0]} != 0",
            }[name],
        )

    def _cpt(self, target: Place, expression: Resolved) -> None:
        self.values.before()
        width = width_of(expression, target)
        self.values.store(target, self.values.term(expression, width), 0 if width == 0 else LINT.bits)

    def _sqr(self, source: Resolved, target: Place) -> None:
        self._compute("SQR", (source,), target)

    def _mov(self, source: Resolved, target: Place) -> None:
        self.values.before()
        self.values.store(target, self.values.term(source, width_of(source)), LINT.bits)

    def _trn(self, source: Resolved, target: Place) -> None:
        self.values.before()
        term = self.values.term(source, width_of(source))
        if term.real:
            term = Term(f"cut({self.values.site}, {term.text})", -(1 << 200), 1 << 200)
        self._store_wide(target, term)

    def _store_wide(self, target: Place, term: Term) -> None:
        """Store an integer that may have any width."""
        kind = target.type
        if kind.is_real or term.fits(LINT.bits):
            self.values.store(target, term, LINT.bits)
            return
        value = self.values.keep(term.text)
        otherwise = f"narrow({self.values.site}, {value}, 256, {kind.bits})"
        text = f"{value} if {kind.lowest} <= {value} <= {kind.highest} else {otherwise}"
        self.values.assign(target, text)
        if self.writer.flags:
            self.values.result_flags(target)

    def _clr(self, target: Place) -> None:
        self.values.before()
        self.values.assign(target, repr(target.type.zero))
        if self.writer.flags:
            self.values.set_flag("S:Z", "True")
            self.values.set_flag("S:N", "False")

    def _combined(self, target: Place, text: str, *, direct: bool) -> None:
        self.values.before()
        self.values.assign(target, text if direct else f"wrap({text}, {target.type.bits})")
        if self.writer.flags:
            self.values.result_flags(target)

    def _combine(self, sign: str, a: Resolved, b: Resolved, target: Place) -> None:
        bits = target.type.bits
        texts = [self.values.filled(each, bits) for each in (a, b)]
        direct = all(_bits(each) == bits for each in (a, b))
        self._combined(target, f"{texts[0]} {sign} {texts[1]}", direct=direct)

    def _not(self, source: Resolved, target: Place) -> None:
        bits = target.type.bits
        self._combined(target, f"~{self.values.filled(source, bits)}", direct=_bits(source) == bits)

    def _mvm(self, source: Resolved, mask: Resolved, target: Place) -> None:
        bits = target.type.bits
        moved, through = self.values.filled(source, bits), self.values.filled(mask, bits)
        direct = _bits(source) == _bits(mask) == bits
        text = f"{self.values.read(target)} & ~{through} | {moved} & {through}"
        self._combined(target, text, direct=direct)

    def _btd(
        self, source: Resolved, source_bit: Constant, target: Place, target_bit: Constant, length: Constant
    ) -> None:
        moved = self.values.filled(source, LINT.bits)
        self.values.assign(
            target,
            f"distributed({moved}, {source_bit.value}, {self.values.read(target)}, "
            f"{target_bit.value}, {length.value}, {target.type.bits})",
        )

    def _swpb(self, source: Place, mode: str, target: Place) -> None:
        self.values.assign(target, f"swapped({self.values.read(source)}, {source.type.bits}, {mode!r})")

    # --- files

    def _cop(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        layout = self.writer.linked.layout
        regions = region_of(source, layout), region_of(target, layout)
        if isinstance(length, Constant) and self._slices(*regions, int(length.value)):
            return
        firsts = [self._first(each) for each in regions]
        count = self.values.term(length, LINT.bits).text
        site = self.values.site
        self.writer.line(f"copy(region[{site}, 0], {firsts[0]}, region[{site}, 1], {firsts[1]}, {count})")

    def _first(self, region: Region) -> str:
        flat = self.values.flat(region.indices, region.dims, region.text)
        return f"({flat}) * {region.rest}" if region.rest != 1 else flat

    def _slices(self, source: Region, target: Region, length: int) -> bool:
        """Write a copy between lists of one type as slices; return whether it could be."""
        first, at = source.fixed_first, target.fixed_first
        if plain(source) is None or plain(source) != plain(target) or first is None or at is None:
            return False
        count = min(length, target.left(at), source.left(first))
        if count < 1:
            return True
        origin, goal = source.parts[0].leaf, target.parts[0].leaf
        text = f"{self.writer.name(origin)}[{first}:{first + count}]"
        if origin.output:
            text += ".tolist()"
        if goal.output:
            text = f'array("h", {text})'
        self.writer.line(f"{self.writer.name(goal)}[{at}:{at + count}] = {text}")
        return True

    def _fll(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        region = region_of(target, self.writer.linked.layout)
        first = self._first(region)
        count = self.values.term(length, LINT.bits).text
        value = self.values.term(source, width_of(source)).text
        self.writer.line(f"fill(region[{self.values.site}, 1], {first}, {count}, {value})")

    # --- program control

    def _jmp(self, label: str) -> None:
        self.writer.line(f"at = {self.sections[label]}")
        self.writer.line("continue")

    def _jsr(self, call: Call) -> None:
        inputs = "".join(f"{self._plain(each)}, " for each in call.inputs)
        if call.routine in self.writer.linked.functions:
            text = f"python({call.routine!r}, ({inputs}))"
        else:
            text = f"{self._functions[call.routine]}(now, ({inputs}))"
        if not call.returns:
            self.writer.line(text)
            return
        answers = self.values.keep(f"{text} or ()")
        for number, place in enumerate(call.returns):
            with self.writer.block(f"if len({answers}) > {number}:"):
                self._take(place, f"{answers}[{number}]")

    def _add_on(self, power: str, call: AddOnCall) -> str:
        power = self._kept(power)
        for series in call.inputs:
            self.series(series, "True", needed=False)
        self.values.set_bit(call.enable_in, power)
        self.values.set_bit(call.enable_out, power)
        logic = f"{self._functions[call.logic]}(now, ())"
        if call.otherwise is None:
            self._either(power, lambda: self.writer.line(logic), lambda: None)
        else:
            otherwise = f"{self._functions[call.otherwise]}(now, ())"
            self._either(power, lambda: self.writer.line(logic), lambda: self.writer.line(otherwise))
        for series in call.outputs:
            self.series(series, "True", needed=False)
        return self.values.keep(self.values.read(call.enable_out))

    def _plain(self, operand: Resolved) -> str:
        return self.values.leaf_term(operand).text

    def _take(self, place: Place, text: str) -> None:
        """Write a parameter into its tag."""
        self.values.before()
        kind = place.type
        value = self.values.keep(f"answer({self.values.site}, {text}, {kind.name!r})")
        if kind.is_bool:
            self.values.set_bit(place, value)
            return
        self.values.assign(place, value)
        if self.writer.flags:
            self.values.result_flags(place)

    def _parameters(self, power: str, places: tuple[Place, ...]) -> None:
        with self.writer.block(f"if {power}:"):
            for number, place in enumerate(places):
                self._take(place, f"given[{number}]")

    def _ret(self, *values: Resolved) -> None:
        self.writer.line(f"return ({''.join(f'{self._plain(each)}, ' for each in values)})")

    def _tnd(self) -> None:
        self.writer.line("return ()")

    def _mcr(self, power: str) -> None:
        if power == "True":
            return
        with self.writer.block(f"if not ({power}):"):
            self.set_override(f"not {self.override}")


def _and(a: str, b: str) -> str:
    if a == "True" or b == "False":
        return b
    return a if b == "True" or a == "False" else f"{a} and {b}"


def _or(texts: list[str]) -> str:
    if "True" in texts:
        return "True"
    live = [each for each in texts if each != "False"]
    if not live:
        return "False"
    return live[0] if len(live) == 1 else f"({' or '.join(live)})"


def _acts_when_true(node: Node) -> bool:
    return isinstance(node, Step) and node.kind is Kind.OUTPUT


def _is_inline(node: Node, *, safe: bool = False) -> bool:
    """Whether a node is an input that is one expression; `safe`: one that can't fault either."""
    if isinstance(node, Parallel):
        return all(_is_inline(each, safe=safe) for leg in node.legs for each in leg)
    if node.kind is not Kind.INPUT or node.name in ("ONS", "SBR", "CMP"):
        return False
    operands = [each for each in node.operands if not isinstance(each, str)]
    safe = safe or node.name == "LIM"  # whose operands are all taken, while Python's a <= b <= c stops early
    return not any(map(_calculates, operands)) and not (safe and any(map(can_fault, operands)))


def _calculates(operand: Resolved) -> bool:
    """Whether an operand or a subscript in it is calculated, which may take lines of its own."""
    if isinstance(operand, Calculation):
        return True
    if isinstance(operand, (Place, Group)):
        inner = [*operand.indices]
        if isinstance(operand, Place) and operand.bit is not None:
            inner.append(operand.bit)
        return any(map(_calculates, inner))
    return False


def _bits(operand: Resolved) -> int:
    assert isinstance(operand, (Place, Constant))
    return operand.type.bits


def _comparing(relation: str) -> Callable[..., str]:
    return lambda self, a, b: self.values.comparison(relation, a, b)


def _computing(operator: str) -> Callable[..., None]:
    return lambda self, *operands: self._compute(operator, operands[:-1], operands[-1])


_INPUTS: dict[str, Callable[..., str]] = {
    **{name: _comparing(relation) for name, relation in COMPARISONS.items()},
    "XIC": RungWriter._xic,
    "XIO": RungWriter._xio,
    "CMP": lambda self, condition: self.values.condition(condition),
    "LIM": RungWriter._lim,
    "MEQ": RungWriter._meq,
    "LBL": lambda _self, _label: "True",
    "AFI": lambda _self: "False",
    "NOP": lambda _self: "True",
}

_OUTPUTS: dict[str, Callable[..., None]] = {
    **{name: _computing(operator) for name, operator in COMPUTATIONS.items()},
    "OTL": lambda self, bit: self.values.set_bit(bit, "True"),
    "OTU": lambda self, bit: self.values.set_bit(bit, "False"),
    "RES": RungWriter._res,
    "CPT": RungWriter._cpt,
    "SQR": RungWriter._sqr,
    "TRN": RungWriter._trn,
    "MOV": RungWriter._mov,
    "MVM": RungWriter._mvm,
    "BTD": RungWriter._btd,
    "CLR": RungWriter._clr,
    "SWPB": RungWriter._swpb,
    "AND": lambda self, a, b, target: self._combine("&", a, b, target),
    "OR": lambda self, a, b, target: self._combine("|", a, b, target),
    "XOR": lambda self, a, b, target: self._combine("^", a, b, target),
    "NOT": RungWriter._not,
    "COP": RungWriter._cop,
    "CPS": RungWriter._cop,
    "FLL": RungWriter._fll,
    "JMP": RungWriter._jmp,
    "JSR": RungWriter._jsr,
    "RET": RungWriter._ret,
    "TND": RungWriter._tnd,
}

_BOTH: dict[str, Callable[..., None]] = {
    "OTE": RungWriter._ote,
    "OSR": RungWriter._osr,
    "OSF": RungWriter._osf,
    "TON": RungWriter._ton,
    "TOF": RungWriter._tof,
    "RTO": RungWriter._rto,
    "CTU": RungWriter._ctu,
    "CTD": RungWriter._ctd,
    "MCR": RungWriter._mcr,
}
