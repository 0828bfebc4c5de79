"""The control channel of served controllers. A request and its answer are JSON objects, one per line.

    {"key": "8c1f..."}         the first line: the key that `serve` printed
    {"fault": "drop=2"}        a fault, as for `--fault`
    {"pin": "in1=ground"}      an input, as for `--pin`
    {"state": 1}               requests the registers, inputs and outputs of the unit at address 1

The answer is {"ok": true}, with "state" and "at_ns" for a "state" request, or {"error": "..."}.

After an answer with the error, the channel closes a connection if its first line is not the key, or if a line
is not JSON. This stops a web page in a browser on this machine, which can send text to any port.
"""

from __future__ import annotations

import hmac
import json
import secrets

from scanrack.io_images.doors import json_value
from scanrack.io_images.text_limits import shortened
from scanrack.runtime.line.ports.textlines import EndOfTalkError, TextLinePort
from scanrack.runtime.loop.pace import Clock

from .line import LOOPBACK, LineService, wire

KEY_BYTES = 16
ALLOWED = '{"fault": TEXT}, {"pin": TEXT} or {"state": ADDRESS}'


class ControlChannel:
    """Answers requests from test programs on this machine.

    Args:
        port: port on the loopback address; 0 = any free port.

    Raises:
        PortError: the port can't be opened.
    """

    def __init__(self, line: LineService, clock: Clock, port: int) -> None:
        self._line, self._clock = line, clock
        self._port = TextLinePort(LOOPBACK, port)
        self.name = self._port.name
        self.key = secrets.token_hex(KEY_BYTES)

    def look(self) -> None:
        """Answer all lines that have arrived."""
        self._port.serve(self.answer)

    def close(self) -> None:
        """Stop listening."""
        self._port.close()

    def answer(self, text: str, is_admitted: bool) -> str:
        """Execute a request; return the answer.

        Args:
            text: the line with the request.
            is_admitted: whether the client has sent the key.

        Raises:
            EndOfTalkError: the line is not JSON, or is the first line and is not the key.
        """
        try:
            request = json_value(text)
        except ValueError:
            problem = f"{shortened(text.strip(), 80)}: this is not JSON; must be {ALLOWED}"
            raise EndOfTalkError(json.dumps({"error": problem})) from None
        if not is_admitted:
            self._admit(request)
            return json.dumps({"ok": True})
        try:
            return json.dumps({"ok": True} | self._carry_out(request, text))
        except ValueError as error:
            return json.dumps({"error": str(error)})

    def _admit(self, request: object) -> None:
        """Raise EndOfTalkError if a request is not the key, which is compared in constant time."""
        key = request.get("key") if isinstance(request, dict) else None
        key_bytes = key.encode("utf-8", "replace") if isinstance(key, str) else b""
        if not hmac.compare_digest(key_bytes, self.key.encode()):
            problem = 'the first line must be {"key": TEXT} with the key that was printed'
            raise EndOfTalkError(json.dumps({"error": problem}))

    def _carry_out(self, request: object, text: str) -> dict[str, object]:
        """Carry out a request; return additional answer keys; raise ValueError for an unknown request."""
        match request:
            case {"fault": str(fault), **rest} if not rest:
                self._line.set_fault(fault)
            case {"pin": str(pin), **rest} if not rest:
                wire(self._line.units, pin)
            case {"state": int(address), **rest} if not rest:
                return self._state(address)
            case _:
                raise ValueError(f"{text.strip()}: must be {ALLOWED}")
        return {}

    def _state(self, address: int) -> dict[str, object]:
        """Return the time and the values of the unit at an address; raise ValueError if there is none."""
        for unit in self._line.units:
            if unit.address == address:
                return {"at_ns": self._clock.now_ns(), "state": unit.values()}
        addresses = ", ".join(str(unit.address) for unit in self._line.units)
        raise ValueError(f"no unit at address {address}; addresses: {addresses}")
