"""The bench: a rack with its program and its machine, driven scan by scan.

    line = open_bench("line.toml")
    line.run_until(lambda line: line.slot[1].status.MOVE_COMPLETE, within="5 s")
    line.slot[1].press("estop", "100 ms")
    assert line["Trouble"], line.why("Trouble")

Made for tests that read as a story. The report of a condition that stays false shows the bench at that time.
"""

from __future__ import annotations

TYPE_CHECKING = False  # a type checker takes it for true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .bench import Bench, ObservedLogic
    from .event_log import BenchEvent
    from .moment import NotReachedError
    from .slot import SlotBench

__all__ = ["Bench", "BenchEvent", "NotReachedError", "ObservedLogic", "SlotBench"]


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
