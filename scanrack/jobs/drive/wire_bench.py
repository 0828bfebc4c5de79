"""The bench of `scanrack drive` for controllers: a controller, its serial line, its pins.

A target (`WireTarget`) provides the controller, its signals and its environment. The bench provides
everything else: the order of the keys, the bytes on the line at the line's speed, time, marks, replies. A
target's module defines

    the options of `new` and the table of `env`       two `Strict` models
    a function that makes a target from the options   raises ValueError for illegal options

and adds `WireBench(make, New, env)` to `targets.BENCHES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Annotated, Any, Generic, Literal, TypeVar

from pydantic import BaseModel, Field, model_validator
from scanrack.runtime.line.wire import ControllerDevice, SerialBus
from scanrack.runtime.loop.events import JsonValue

from .image_bench import NS_PER_MS, time_ms
from .requests import Milliseconds, RequestError, Strict, bytes_of, read

New = TypeVar("New", bound=BaseModel)
Env = TypeVar("Env", bound=BaseModel)
PinState = TypeVar("PinState")

MARKED = "position_minus_mark:"


@dataclass(frozen=True, slots=True)
class WireTarget(Generic[Env]):
    """A controller on the bench.

    The bench advances the device to the current time before it calls any of the functions.
    """

    device: ControllerDevice
    signals: Mapping[str, Callable[[], JsonValue]]  # functions that return the observable signals, by name
    set_env: Callable[[int, Env], None]  # sets pins and voltages at a time, ns; None = unchanged
    silence_ns: int  # maximum wait for a reply after the last byte sent, ns
    quiet_ns: Callable[[], int] = lambda: 0  # returns the required silence before a frame, ns
    has_reset: bool = False  # whether it has a reset button, which cycles the power


def pin_state(
    value: Any, levels: Mapping[str, PinState], followers: Mapping[str, Callable[[int], PinState]], forms: str
) -> PinState:
    """Return a pin's state for a requested value: a level, or a state that follows the position.

    Args:
        levels: states by name.
        followers: functions that return the state for a position, by key.
        forms: allowed values, for the message.

    Raises:
        ValueError: the value has none of the forms.
    """
    if isinstance(value, str) and value in levels:
        return levels[value]
    if isinstance(value, dict) and len(value) == 1:
        [(key, position)] = value.items()
        if key in followers and isinstance(position, int) and not isinstance(position, bool):
            return followers[key](position)
    raise ValueError(f"must be {forms}")


class WireRequest(Strict, Generic[New, Env]):
    """A request to a controller."""

    new: New | None = None
    power_cycle: Literal[True] | None = None
    reset: Literal[True] | None = None
    env: Env | None = None
    mark: Annotated[str, Field(min_length=1)] | None = None
    tx: str | None = None
    tx_text: str | None = None
    char_gap_ms: Milliseconds = Decimal(0)
    for_ms: Milliseconds = Decimal(0)
    observe: list[str] | None = None

    @model_validator(mode="after")
    def _has_one_kind_of_bytes(self) -> WireRequest[New, Env]:
        """Refuse bytes both in hex and as text, and a gap between bytes that are not text."""
        if self.tx is not None and self.tx_text is not None:
            raise ValueError("send tx or tx_text, not both")
        if self.char_gap_ms and self.tx_text is None:
            raise ValueError("char_gap_ms: only allowed with tx_text")
        return self

    def bytes_to_send(self) -> bytes | None:
        """Return the bytes to send; None = nothing; raise RequestError for illegal bytes."""
        if self.tx is not None:
            data = bytes_of(self.tx)
        elif self.tx_text is not None:
            try:
                data = self.tx_text.encode("latin-1")
            except UnicodeEncodeError:
                raise RequestError("tx_text: characters above U+00FF are not allowed") from None
        else:
            return None
        if not data:
            raise RequestError("tx: must have at least one byte")
        return data


class WireBench(Generic[New, Env]):
    """A controller on the bench.

    Args:
        make: creates a target from the options of a fresh bench; raises ValueError for illegal options.
        new: model of the options; all options have defaults.
        env: model of the controller's environment; the default of every key is None.
    """

    def __init__(self, make: Callable[[New], WireTarget[Env]], new: type[New], env: type[Env]) -> None:
        self._make = make
        self._model: type[WireRequest[New, Env]] = WireRequest[new, env]  # type: ignore[valid-type]
        self._renew(make(new()))

    def _renew(self, target: WireTarget[Env]) -> None:
        self.target = target
        self.bus = SerialBus(target.device)
        self._marks: dict[str, int] = {}

    def answer(self, line: str) -> dict[str, Any]:
        """Carry out the request in a line; return the reply that `drive` prints.

        Raises:
            RequestError: the request is illegal; nothing has changed.
        """
        request = read(line, self._model)
        data = request.bytes_to_send()
        new_target = self._check(request)
        if new_target is not None:
            self._renew(new_target)
        self._set(request)
        reply: dict[str, Any] = {}
        if data is not None:
            received = self._exchange(data, int(request.char_gap_ms * NS_PER_MS))
            reply["rx"] = received.hex(" ") or None
            reply["rx_text"] = received.decode("latin-1") or None
        self.bus.run_until(self.bus.now_ns + int(request.for_ms * NS_PER_MS))
        if request.observe is not None:
            reply["values"] = {name: self._value(name) for name in request.observe}
        return {"t_ms": time_ms(self.bus.now_ns), **reply}

    def _check(self, request: WireRequest[New, Env]) -> WireTarget[Env] | None:
        """Return the target of a fresh bench; None to continue with the bench.

        Raises:
            RequestError: the request is illegal.
        """
        try:
            new_target = None if request.new is None else self._make(request.new)
        except ValueError as error:
            raise RequestError(f"new: {error}") from None
        if request.reset and not self.target.has_reset:
            raise RequestError("reset: this controller has no reset button; use power_cycle")
        marks = () if new_target else tuple(self._marks)
        signal_names = {*self.target.signals, *(MARKED + mark for mark in (*marks, request.mark or ""))}
        for name in request.observe or ():
            if name not in signal_names:
                choices = ", ".join((*self.target.signals, MARKED + "NAME"))
                problem = f'observe: "{name}" is not a signal, or its mark is not set'
                raise RequestError(f"{problem}; choose from {choices}")
        return new_target

    def _set(self, request: WireRequest[New, Env]) -> None:
        """Apply the parts of a request that precede its bytes: power, pins, a mark."""
        now_ns = self.bus.now_ns
        self.bus.run_until(now_ns)
        for is_cycled in (request.power_cycle, request.reset):
            if is_cycled:
                self.target.device.power_cycle(now_ns)
        if request.env is not None:
            self.target.set_env(now_ns, request.env)
        self.bus.run_until(now_ns)
        if request.mark is not None:
            self._marks[request.mark] = self.target.device.motor_position

    def _exchange(self, data: bytes, gap_ns: int) -> bytes:
        """Send bytes with a gap after each byte; return the reply, or b"" if none begins in `silence_ns`."""
        bus, target = self.bus, self.target
        if bus.quiet_since_ns is not None:
            bus.run_until(max(bus.now_ns, bus.quiet_since_ns + target.quiet_ns()))
        bus.take()
        sent_ns = bus.send(data, target.device.line_format, gap_ns)
        bus.run_until(sent_ns)
        deadline_ns = sent_ns + target.silence_ns
        while not (bus.heard and bus.is_idle):
            due_ns = bus.next_event_ns()
            if due_ns is None or (due_ns > deadline_ns and bus.is_idle):
                bus.run_until(deadline_ns)
                break
            bus.run_until(due_ns)
        return bus.take()

    def _value(self, name: str) -> JsonValue:
        if name.startswith(MARKED):
            return self.target.device.motor_position - self._marks[name.removeprefix(MARKED)]
        return self.target.signals[name]()
