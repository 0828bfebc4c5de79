"""Traces of exchanges, with one scan for each exchange at the time of its reply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from struct import Struct

from scanrack.traces.format.layout import SlotInfo, block_layout
from scanrack.traces.format.tagplan import Tag, TagPlan, plan_of
from scanrack.traces.write.recorder import ScanRecorder

from .device_values import ALWAYS, VALUES, Values
from .pairing import PairedExchange

SCAN_PERIOD_NS = 1_000_000
"""Nominal scan period for a trace whose scans have individual times, ns."""

RUN_MODE = 1
EXCEPTION = 0x80


class ExchangeTags:
    """The values of the current exchange as tags, see `traces.format.tagplan.TagSource`."""

    def __init__(self, plan: TagPlan, images: bytes) -> None:
        self.plan, self._images = plan, images
        self.pending: list[tuple[str, Mapping[str, str | int]]] = []
        self.values: dict[str, float] = {field.tag.name: 0 for field in plan.fields}
        self._row = Struct(f"<{plan.letters}")

    def take(self) -> bytes:
        """Return the empty images of the slot, and the row of tags."""
        return self._images + self._row.pack(*(self.values[field.tag.name] for field in self.plan.fields))


@dataclass(frozen=True, slots=True)
class Statement:
    """An exchange, and the controller's values in it, by name."""

    exchange: PairedExchange
    values: Values


def statements_of(controller: str, exchanges: Sequence[PairedExchange]) -> list[Statement]:
    """Return the exchanges with a controller, `pcl601` or `pmc006`, and the values that they show."""
    words: dict[int, int] = {}
    return [Statement(exchange, VALUES[controller](exchange, words)) for exchange in exchanges]


def value_names(*traces: Sequence[Statement]) -> list[str]:
    """Return the names of all values, in order of first appearance."""
    return list(dict.fromkeys(name for trace in traces for statement in trace for name in statement.values))


def record(target: Path, controller: str, statements: Sequence[Statement], names: Sequence[str]) -> None:
    """Write a trace of exchanges. Scan 0 is the first exchange, and time begins at its request.

    Args:
        names: names of the values that become tags, see `value_names`.

    Raises:
        OSError: the file can't be written.
    """
    slot = SlotInfo(1, controller)
    images = bytes(block_layout([slot]).size)
    tags = ExchangeTags(plan_of([*(Tag(name, "DINT") for name in names), *ALWAYS]), images)
    begin_ns = statements[0].exchange.requested_ns
    facts = {"name": target.stem, "controller": controller, "source": "capture"}
    recorder = ScanRecorder(
        target, bytearray(images), [slot], scan_period_ns=SCAN_PERIOD_NS, metadata=facts, tags=tags
    )
    with closing(recorder):
        for number, statement in enumerate(statements):
            tags.values.update(statement.values)
            tags.values.update(_facts(controller, statement.exchange))
            recorder.scan(number, statement.exchange.answered_ns - begin_ns, RUN_MODE)


def _facts(controller: str, exchange: PairedExchange) -> dict[str, float]:
    """Return the tags common to all exchanges; the exception code is 0 if the request was not refused."""
    reply = exchange.reply
    exception = 0
    if controller == "pcl601" and reply is not None and len(reply) > 1 and reply[0] & EXCEPTION:
        exception = reply[1]
    return {
        "function": exchange.request[0],
        "exception": exception,
        "answered": reply is not None,
        "reply_ms": (exchange.answered_ns - exchange.requested_ns) / 1e6,
    }
