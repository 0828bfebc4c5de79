"""The responses of a simulated controller to the requests of a capture.

    request   sent  |<---- window ---->| answered
    early model     x acts, is read    x is read
    late model      x is read          x acts, is read

The real controller acts at some instant between request and reply. Two models therefore run: one acts as
early as possible, the other as late as possible. A real value is explained if it lies within the range that
the models show at both ends of the window. The simulated trace then contains the real value. Otherwise it
contains the nearest value that the models show.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from scanrack.io_images.pmc006.frame import FRAME_BYTES, command, decode
from scanrack.io_images.pmc006.instructions import BY_CODE, Kind
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line import pcl601_pdus as pdus

from .device_values import VALUES, Values
from .pairing import PairedExchange
from .recording import Statement

Respond = Callable[[int, PairedExchange], bytes | None]
"""Returns the reply to a request at an instant, ns; instants never decrease."""


def simulated(controller: str, statements: Sequence[Statement]) -> list[Statement]:
    """Return the statements of a simulated controller that is powered up at the first request.

    Scan n of both traces is the same exchange at the same time. A request without a reply is assumed to have
    been carried out.

    Args:
        controller: `pcl601` or `pmc006`.
        statements: statements of the real controller.
    """
    begin_ns, unit = statements[0].exchange.requested_ns, statements[0].exchange.unit
    early, late = (_Model(controller, MODELS[controller](unit), begin_ns) for _ in range(2))
    return [
        _modeled(statement, early, late, reads=_is_read(controller, statement.exchange))
        for statement in statements
    ]


def _is_read(controller: str, exchange: PairedExchange) -> bool:
    if controller == "pcl601":
        return exchange.request[0] in pdus.READS
    row = BY_CODE.get(exchange.request[0])
    return row is not None and row.kind is Kind.READ


def _modeled(real: Statement, early: _Model, late: _Model, *, reads: bool) -> Statement:
    """Return the models' statement: the late model's reply, and the values nearest to the real values."""
    exchange = real.exchange
    if exchange.reply is None:
        if not reads:
            early.carry_out(exchange.requested_ns, exchange)
            late.carry_out(exchange.requested_ns, exchange)
        return real
    shown = [early.carry_out(exchange.requested_ns, exchange)[1]]
    if reads:  # at both ends of the window; other requests act once in each model
        shown.append(early.carry_out(exchange.answered_ns, exchange)[1])
        shown.append(late.carry_out(exchange.requested_ns, exchange)[1])
    reply, values = late.carry_out(exchange.answered_ns, exchange)
    shown.insert(0, values)  # first, because `_nearest` returns the first value if there is no real one
    nearest = {name: _nearest(real.values.get(name), name, shown) for name in values}
    return Statement(replace(exchange, reply=reply), nearest)


def _nearest(real: int | None, name: str, shown: Sequence[Values]) -> int:
    """Return the value nearest to the real value in the range of the shown values."""
    numbers = [values[name] for values in shown if name in values]
    return numbers[0] if real is None else min(max(real, min(numbers)), max(numbers))


class _Model:
    """A simulated controller, and the words that it has shown so far."""

    def __init__(self, controller: str, respond: Respond, begin_ns: int) -> None:
        self._values_in = VALUES[controller]
        self._respond = respond
        self._begin_ns = begin_ns
        self._now_ns = 0
        self._words: dict[int, int] = {}

    def carry_out(self, at_ns: int, exchange: PairedExchange) -> tuple[bytes | None, Values]:
        """Carry out a request at an instant of the capture; return the reply and its values."""
        self._now_ns = max(self._now_ns, at_ns - self._begin_ns)
        reply = self._respond(self._now_ns, exchange)
        return reply, self._values_in(replace(exchange, reply=reply), self._words)


def _pcl601(_unit: int) -> Respond:
    """Return a function that answers like a PCL601, whatever its address."""
    device = Pcl601()

    def respond(now_ns: int, exchange: PairedExchange) -> bytes | None:
        device.advance(now_ns)
        return device.answer(exchange.request)

    return respond


def _pmc006(unit: int) -> Respond:
    """Return a function that answers like a PMC006 with an address."""
    device = Pmc006(Pmc006Controller(address=unit))

    def respond(now_ns: int, exchange: PairedExchange) -> bytes | None:
        instruction, data = exchange.request[0], exchange.request[1:5]
        device.advance(now_ns)
        device.receive(now_ns, command(unit, instruction, int.from_bytes(data, "little", signed=True)))
        reply = decode(device.advance(now_ns)[-FRAME_BYTES:])
        return None if reply is None else reply.data.to_bytes(4, "little", signed=True)

    return respond


MODELS: dict[str, Callable[[int], Respond]] = {"pcl601": _pcl601, "pmc006": _pmc006}
