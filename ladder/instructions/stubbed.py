"""The base row of the `Spec` of a stubbed instruction; see `stubs`.

rung      ____|‾‾‾‾|_____________
EN        ____|‾‾‾‾‾‾‾‾‾‾|_______     of the first operand with EN and DN
IP        ____|‾‾‾‾‾‾|___________     for the time that the stub names
DN, ER    ___________|‾‾‾‾‾‾‾‾‾‾‾     until the next rising rung; PC like DN
"""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.dataclass import dataclass

from ..interpreter import Interpreter
from ..model.arithmetic import wrap
from ..model.errors import LadderError
from ..model.operand_checks import OperandError
from ..model.operands import Constant, Group, Place, Resolved, StringConstant, width_of
from ..model.spec import InstructionKind, Spec, Use
from ..model.stubs import Ending, InPython, Power, Stub, replaces
from ..model.tree import Operand
from ..model.types import Structure
from ..state.lowered import OperandResolver
from ..state.memory import Value

STARTED = "started_ns"
"""Hidden member with the start time of an instruction."""


class Argument:
    """A tag operand of a Python stub: `argument.value`, or `argument["PRE"]` of a structure."""

    __slots__ = ("_machine", "_tag", "name")

    def __init__(self, machine: Interpreter, tag: Place | Group) -> None:
        self._machine, self._tag, self.name = machine, tag, tag.text

    @property
    def value(self) -> Value:
        """The value of a plain tag; a structure or array raises a ValueError."""
        return self._machine.get(self._place())

    @value.setter
    def value(self, value: Value) -> None:
        self._put(self._place(), value)

    def __getitem__(self, member: str) -> Value:
        """Return a member of a structure."""
        return self._machine.get(self._member(member))

    def __setitem__(self, member: str, value: Value) -> None:
        """Set a member of a structure."""
        self._put(self._member(member), value)

    def _put(self, place: Place, value: Value) -> None:
        self._machine.put(place, bool(value) if place.type.is_bool else value)

    def _place(self) -> Place:
        if isinstance(self._tag, Group):
            raise ValueError(f"{self.name} is a structure or an array; name a member, as in operand['PRE']")
        return self._tag

    def _member(self, name: str) -> Place:
        place = self._tag.find_member(name) if isinstance(self._tag, Group) else None
        if place is None:
            raise ValueError(f"{self.name} has no member {name}")
        return place


@dataclass(frozen=True, slots=True)
class TimedCall:
    """The members of an instruction that takes time to finish."""

    bits: Mapping[str, Place]  # the members EN, DN, ER, IP and PC that exist
    error: Place | None  # member ERR, or None
    started: Place  # start time, ns


def _timed(resolver: OperandResolver, operands: tuple[Resolved | None, ...]) -> TimedCall:
    """Return the members of the first operand with EN and DN; raise an OperandError if none has them."""
    for operand in operands:
        if isinstance(operand, Group) and operand.find_member("EN") and operand.find_member("DN"):
            assert isinstance(operand.type, Structure)
            has_start_member = any(hidden.name == STARTED for hidden in operand.type.hidden)
            places = {name: operand.find_member(name) for name in ("EN", "DN", "ER", "IP", "PC")}
            bits = {name: place for name, place in places.items() if place}
            started = operand.member(f"~{STARTED}") if has_start_member else resolver.hidden(STARTED)
            return TimedCall(bits, operand.find_member("ERR"), started)
    raise OperandError("no operand has EN and DN to show that it is done", "write false or true as its stub")


def _time_call(machine: Interpreter, power: bool, stub: Ending, timed: TimedCall) -> bool:
    """Begin the instruction on a rising rung, or end it after the stub's time; return the power after it."""
    state = {name: machine.truth(machine.get(place)) for name, place in timed.bits.items()}
    ended = state["DN"] or state.get("ER", False)
    if not state["EN"]:
        if power:
            _set_bits(machine, timed, EN=True, DN=False, ER=False, IP=True, PC=False)
            machine.put(timed.started, machine.now_ns)
        return power
    if not ended and machine.now_ns - machine.whole(machine.get(timed.started)) >= stub.after_ns:
        ended = True
        good = not stub.error or "ER" not in timed.bits
        _set_bits(machine, timed, DN=good, ER=not good, IP=False, PC=good)
        if timed.error is not None:
            machine.put(timed.error, wrap(stub.error, timed.error.type.wraps))
    if ended and not power:
        _set_bits(machine, timed, EN=False)
    return power


def _set_bits(machine: Interpreter, timed: TimedCall, **bits: bool) -> None:
    for name, value in bits.items():
        if name in timed.bits:
            machine.put(timed.bits[name], value)


def _resolved(resolver: OperandResolver, operand: Operand) -> Resolved | None:
    """Resolve an operand; None if it is neither a tag nor a number."""
    try:
        return resolver.any_operand(operand)
    except LadderError:
        return None


def _stub_argument(machine: Interpreter, operand: Resolved | str) -> object:
    """Return an operand as the argument of a Python stub."""
    if isinstance(operand, (Place, Group)):
        return Argument(machine, operand)
    if isinstance(operand, (Constant, StringConstant)):
        return operand.value
    return operand if isinstance(operand, str) else machine.number(operand, width_of(operand))


def _run(machine: Interpreter, power: bool, stub: Stub, *operands: object) -> bool:
    """Run the stub: pass or block power, begin or end a timed call, or call Python; return the power."""
    if isinstance(stub, Power):
        return power and stub.after
    if isinstance(stub, Ending):
        (timed,) = operands
        assert isinstance(timed, TimedCall)
        return _time_call(machine, power, stub, timed)
    name, *arguments = operands
    results = machine.call(str(name), (power, *(_stub_argument(machine, argument) for argument in arguments)))  # type: ignore[arg-type]
    return power if not results else bool(results[0])


def stub_spec(name: str, stub: Stub) -> Spec:
    """Return the spec of a stubbed instruction; its name is in capitals."""

    def resolve(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[object, ...]:
        """Return the stub, and the operands that it needs; see `_run`."""
        if isinstance(stub, Power):
            return (stub,)
        resolved = tuple(_resolved(resolver, argument) for argument in operands)
        if isinstance(stub, Ending):
            return stub, _timed(resolver, resolved)
        assert isinstance(stub, InPython)  # a consumed tag is not an instruction, see `replaces`
        arguments = (
            str(operand) if value is None else value
            for operand, value in zip(operands, resolved, strict=True)
        )
        return stub, resolver.function(name, stub.function), *arguments

    return Spec(name, InstructionKind.BOTH, (Use.ANYTHING,), run=_run, resolve=resolve, decides=True)


def specs_of_stubs(stubs: Mapping[str, Stub]) -> dict[str, Spec]:
    """Return the specs of stubbed instructions, by uppercase name."""
    return {name: stub_spec(name, stub) for name, stub in stubs.items() if replaces(stubs, name) is not None}
