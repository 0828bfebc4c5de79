"""The control channel of served controllers: JSON objects, one a line, each answered by one.

    {"fault": "drop=2"}        a fault, as `--fault` has it
    {"pin": "in1=ground"}      an input, as `--pin` has it
    {"state": 1}               the registers, inputs and outputs of the unit at address 1

An answer is {"ok": true}, with "state" and "at_ns" if it was asked for, or {"error": "..."}.
"""

from __future__ import annotations

import json

from ...runtime.line.ports.textlines import TextLinePort
from ...runtime.loop.pace import Clock
from .line import LOOPBACK, ServedLine, wire

ALLOWED = '{"fault": TEXT}, {"pin": TEXT} or {"state": ADDRESS}'


class ControlChannel:
    """Answers the lines of test programs on this machine.

    Args:
        port: on the loopback address, 0 = any that is free.

    Raises:
        PortError: it can't listen there.
    """

    def __init__(self, line: ServedLine, clock: Clock, port: int) -> None:
        self._line, self._clock = line, clock
        self._port = TextLinePort(LOOPBACK, port)
        self.name = self._port.name

    def look(self) -> None:
        """Answer the lines that have arrived."""
        self._port.serve(self.answer)

    def close(self) -> None:
        """Stop listening."""
        self._port.close()

    def answer(self, text: str) -> str:
        """Carry out a line; return its answer."""
        try:
            return json.dumps({"ok": True} | self._carry_out(text))
        except ValueError as error:
            return json.dumps({"error": str(error)})

    def _carry_out(self, text: str) -> dict[str, object]:
        match _object(text):
            case {"fault": str(fault), **rest} if not rest:
                self._line.set_fault(fault)
            case {"pin": str(pin), **rest} if not rest:
                wire(self._line.units, pin)
            case {"state": int(address), **rest} if not rest:
                return self._state(address)
            case _:
                raise ValueError(f"{text.strip()}: it has to be {ALLOWED}")
        return {}

    def _state(self, address: int) -> dict[str, object]:
        for unit in self._line.units:
            if unit.address == address:
                return {"at_ns": self._clock.now_ns(), "state": unit.values()}
        there = ", ".join(str(unit.address) for unit in self._line.units)
        raise ValueError(f"there is no unit at address {address}: there is {there}")


def _object(text: str) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError(f"{text.strip()}: it is not JSON; it has to be {ALLOWED}") from None
