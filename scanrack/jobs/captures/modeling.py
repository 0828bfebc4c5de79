"""Sends the same requests to a simulated controller, to find what it would have answered.

    request   sent  |<---- window ---->| answered
    early model     x acts, is read    x is read
    late model      x is read          x acts, is read

The instant at which the real controller acts lies somewhere between request and reply. So there are two
models: one acts as early as possible, the other as late as possible. A real value between the lowest and
highest values that they show at both ends of the window is explained, and the model's value is set to it.
Otherwise the model's value is the nearest one shown.
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

Answer = Callable[[int, PairedExchange], bytes | None]
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
    exchange = real.exchange
    if exchange.reply is None:
        if not reads:
            early.ask(exchange.requested_ns, exchange)
            late.ask(exchange.requested_ns, exchange)
        return real
    seen = [early.ask(exchange.requested_ns, exchange)]
    if reads:
        seen += [early.ask(exchange.answered_ns, exchange), late.ask(exchange.requested_ns, exchange)]
    reply, values = late.ask(exchange.answered_ns, exchange)
    shown = [values, *(earlier for _, earlier in seen)]
    explained = {name: _nearest(real.values.get(name), name, shown) for name in values}
    return Statement(replace(exchange, reply=reply), explained)


def _nearest(real: int | None, name: str, shown: Sequence[Values]) -> int:
    """Return the value in the range of the shown values that is nearest to the real one."""
    numbers = [values[name] for values in shown if name in values]
    return numbers[0] if real is None else min(max(real, min(numbers)), max(numbers))


class _Model:
    """A simulated controller, and the words that it has shown so far."""

    def __init__(self, controller: str, answer: Answer, begin_ns: int) -> None:
        self._values_in = VALUES[controller]
        self._answer = answer
        self._begin_ns = begin_ns
        self._now_ns = 0
        self._words: dict[int, int] = {}

    def ask(self, at_ns: int, exchange: PairedExchange) -> tuple[bytes | None, Values]:
        """Carry out a request at an instant of the capture; return the reply and its values."""
        self._now_ns = max(self._now_ns, at_ns - self._begin_ns)
        reply = self._answer(self._now_ns, exchange)
        return reply, self._values_in(replace(exchange, reply=reply), self._words)


def _pcl601(_unit: int) -> Answer:
    device = Pcl601()

    def answer(now_ns: int, exchange: PairedExchange) -> bytes | None:
        device.advance(now_ns)
        return device.answer(exchange.request)

    return answer


def _pmc006(unit: int) -> Answer:
    device = Pmc006(Pmc006Controller(address=unit))

    def answer(now_ns: int, exchange: PairedExchange) -> bytes | None:
        data = int.from_bytes(exchange.request[1:5], "little", signed=True)
        device.advance(now_ns)
        device.receive(now_ns, command(unit, exchange.request[0], data))
        reply = decode(device.advance(now_ns)[-FRAME_BYTES:])
        return None if reply is None else reply.data.to_bytes(4, "little", signed=True)

    return answer


MODELS: dict[str, Callable[[int], Answer]] = {"pcl601": _pcl601, "pmc006": _pmc006}
