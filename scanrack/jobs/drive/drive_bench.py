"""The bench of `scanrack drive` for networked drives: Modbus TCP requests and replies in virtual time."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import Field
from scanrack.io_images.drives.models import Model
from scanrack.runtime.line.ports.modbustcp import HEADER, NotModbusError, reply_frame, split_frames
from scanrack.runtime.machine import Switch
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.registers import DriveRegisters

from .image_bench import NS_PER_MS, time_ms
from .requests import Milliseconds, RequestError, Span, Strict, bytes_of, read


class SwitchRange(Strict):
    """The range of shaft positions where an input is on, in steps from the position at power-up."""

    on_when_pos_in: Span


Level = Literal["on", "off"] | SwitchRange


class DriveEnv(Strict):
    """New input levels and conditions of an axis; None = unchanged."""

    in1: Level | None = None
    in2: Level | None = None
    capture: Level | None = None
    external: Level | None = None
    home: Level | None = None
    cw_limit: Level | None = None
    ccw_limit: Level | None = None
    temperature_c: Annotated[float, Field(ge=-273, le=1000)] | None = None
    driver_fault: bool | None = None
    encoder_error: bool | None = None
    stall: Literal[True] | None = None
    cable: Literal["connected", "lost"] | None = None
    connection: Literal["lost"] | None = None


class DriveNew(Strict):
    """Options of a fresh bench."""

    axes: Annotated[int, Field(ge=1, strict=True)] = 1
    options: dict[str, Any] = Field(default_factory=dict)


class DriveRequest(Strict):
    """A request to a stack of drives."""

    new: DriveNew | None = None
    power_cycle: Literal[True] | None = None
    axis: Annotated[int, Field(ge=1, strict=True)] = 1
    env: DriveEnv | None = None
    tx: str | None = None
    for_ms: Milliseconds = Decimal(0)
    observe: list[Literal["position", "encoder_counts", "flash_writes"]] | None = None


class DriveBench:
    """A stack of drives on the bench."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._renew(DriveNew())

    def _renew(self, new: DriveNew) -> None:
        """Start a fresh stack at time 0; raise RequestError for too many axes or a wrong option."""
        if new.axes > self.model.axes:
            raise RequestError(f"new.axes: {new.axes} is too many: must be 1 to {self.model.axes}")
        try:
            axes = [DriveUnit(self.model, options=new.options) for _ in range(new.axes)]
        except ValueError as error:
            raise RequestError(f"new: {error}") from None
        self.axes, self.registers, self.now_ns = axes, DriveRegisters(axes), 0

    def answer(self, line: str) -> dict[str, Any]:
        """Carry out the request in a line; return the reply that `drive` prints.

        Raises:
            RequestError: the request is illegal; nothing has changed.
        """
        request = read(line, DriveRequest)
        frame = None if request.tx is None else _frame(request.tx)
        axes = len(self.axes) if request.new is None else request.new.axes
        if request.axis > axes:
            raise RequestError(f"axis: {request.axis} does not exist: must be 1 to {axes}")
        self._set(request)
        reply: dict[str, Any] = {} if frame is None else {"rx": self._reply_to(frame)}
        self.now_ns += int(request.for_ms * NS_PER_MS)
        for axis in self.axes:
            axis.advance(self.now_ns)
        if request.observe is not None:
            reply["values"] = {name: _observed(self.axes[request.axis - 1], name) for name in request.observe}
        reply["events"] = [event.text for axis in self.axes for event in axis.events]
        for axis in self.axes:
            axis.events.clear()
        return {"t_ms": time_ms(self.now_ns), **reply}

    def _reply_to(self, frame: bytes) -> str | None:
        """Return the drives' reply to a frame in hex; None if they do not reply."""
        reply = reply_frame(frame, self.registers.answer(frame[HEADER.size :])) if frame else None
        return None if reply is None else reply.hex(" ")

    def _set(self, request: DriveRequest) -> None:
        """Apply the parts of a request that precede its frame: fresh stack, power cycle, conditions."""
        levels = {} if request.env is None else self._levels(request.env)
        if request.new is not None:
            self._renew(request.new)
        if request.power_cycle:
            for axis in self.axes:
                axis.power_cycle()
        if request.env is not None:
            _set_env(self.axes[request.axis - 1], request.env, levels)

    def _levels(self, env: DriveEnv) -> dict[str, Level]:
        """Return the levels that a request sets, by input; raise RequestError if the model lacks an input."""
        names = self.model.input_names
        levels = {name: getattr(env, name) for name in INPUTS if getattr(env, name) is not None}
        for name in levels:
            if name not in names:
                raise RequestError(f"env.{name}: the {self.model.title} has {', '.join(names)}")
        return levels


INPUTS = ("in1", "in2", "capture", "external", "home", "cw_limit", "ccw_limit")


def _frame(text: str) -> bytes:
    """Return a request's frame, b"" if a drive ignores its bytes; raise RequestError for illegal text."""
    try:
        frames, surplus = split_frames(bytes_of(text))
    except NotModbusError:
        return b""
    return frames[0] if len(frames) == 1 and not surplus else b""


def _set_env(axis: DriveUnit, env: DriveEnv, levels: dict[str, Level]) -> None:
    """Set the inputs of an axis and the conditions of its drive. Conditions that are None do not change."""
    for name, level in levels.items():
        bit = axis.terminals[axis.model.input_names.index(name)]
        if isinstance(level, SwitchRange):
            axis.machine.rewire(bit, [Switch(bit, *level.on_when_pos_in)])
        else:
            axis.machine.rewire(bit, [])
            axis.machine.set_input(bit, level == "on")
    if env.temperature_c is not None:
        axis.set_temperature(env.temperature_c)
    if env.driver_fault is not None:
        axis.set_driver_fault(env.driver_fault)
    if env.encoder_error is not None:
        axis.set_encoder_error(env.encoder_error)
    if env.stall:
        axis.stall()
    if env.cable is not None:
        axis.set_cable(env.cable == "connected")
    if env.connection is not None:
        axis.lose_connection()


def _observed(axis: DriveUnit, name: str) -> int:
    shaft, counts, _ = axis.figures()
    return {"position": shaft, "encoder_counts": counts, "flash_writes": axis.memory.writes}[name]
