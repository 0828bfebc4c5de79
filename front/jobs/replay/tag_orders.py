"""Orders on the tags of a program in a recording, given again during its replay.

/orders    of a session: writes, forces and releases, in order
/forces    of any other recording: the forced tags with their values; writes are not recorded
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

from ...ladder import LadderLogic
from ...ladder.python.online import Fields
from ...ladder.python.sequences import Logic
from ...runtime.live.hands import Desk, GivenOrder, Hands
from ...runtime.live.orders import Force, Unforce, Write
from ...runtime.loop.cpu import Cpu
from ...runtime.loop.rack import Rack
from ...runtime.loop.scan import ScanFlag, ScanLogic
from ...traces.format.topics import ORDERS
from ...traces.read.reader import TraceEvent
from ..record.order_repeater import OrderRepeater, orders_of
from ..run.playback import Score

Forced = Mapping[str, str | int | float | bool]

_TOLD = 3


class TagOrders:
    """The orders on tags in a recording.

    Raises:
        ValueError: an order of the recording can't be read.
    """

    def __init__(self, score: Score, events: Sequence[TraceEvent]) -> None:
        session = any(event.topic == ORDERS.name for event in events)
        given = orders_of(events) if session else _of_forces(events)
        self._given = [each for each in given if isinstance(each.order, Write | Force | Unforce)]
        self.notes = [] if session else list(_unknown(score, events))  # orders that can't be repeated

    def program(self, logic: ScanLogic) -> ScanLogic:
        """Return the program to run: a ladder program under a debugger if there are orders."""
        if not self._given or not isinstance(logic, LadderLogic):
            return logic
        from ...ladder.debug import Debugger  # most recordings need none

        return Debugger(logic, remembered=0)

    def give(self, cpu: Cpu, rack: Rack, logic: ScanLogic) -> OrderRepeater:
        """Give the orders again before the same scans of a CPU; return the repeater, with its refusals.

        Args:
            cpu: runs the program, no scan yet.
            logic: the program of `program`.
        """
        from ...ladder.debug import Debugger

        desk: Desk | None = logic if isinstance(logic, Debugger) else None
        if isinstance(logic, Logic):
            desk = Fields(lambda: logic)
        repeated = OrderRepeater(cpu, Hands(cpu, rack, desk), self._given)
        cpu.add_listener(repeated)
        repeated.begin()
        return repeated


def _of_forces(events: Sequence[TraceEvent]) -> Iterator[GivenOrder]:
    before: Forced = {}
    for event in events:
        if event.topic == "/forces":
            after = _forced(event)
            gone: list[Force | Unforce] = [Unforce(tag) for tag in before if tag not in after]
            come = [Force(tag, after[tag]) for tag in after if before.get(tag) != after[tag]]
            for order in gone + come:
                yield GivenOrder(event.scan, order)
            before = after


def _forced(event: TraceEvent) -> Forced:
    tags = event.fields.get("tags")
    return tags if isinstance(tags, Mapping) else {}


def _unknown(score: Score, events: Sequence[TraceEvent]) -> Iterator[str]:
    """Yield a note if tags were set to values that are not recorded."""
    changes = {event.scan: bool(_forced(event)) for event in events if event.topic == "/forces"}
    forced = False
    scans = []
    for number, flags in zip(score.numbers, score.flags, strict=True):
        forced = changes.get(number, forced)
        if flags & ScanFlag.TAGS_FROM_OUTSIDE and not forced and number not in changes:
            scans.append(number)
    if scans:
        times = f"{len(scans):,} scan{'s' * (len(scans) != 1)}, first before scan {scans[0]:,}"
        yield f"tags were set from outside before {times}: the trace does not have the values"


def first_few(sentences: Sequence[str]) -> list[str]:
    """Return the first sentences, and their total if some are left out.

    >>> first_few(["a", "b"])
    ['a', 'b']
    >>> first_few("abcde")
    ['a', 'b', 'c', 'and so on, 5 times in all']
    """
    few = list(islice(sentences, _TOLD))
    return few if len(sentences) <= _TOLD else [*few, f"and so on, {len(sentences):,} times in all"]
