"""The bench: a rack with its program and its machine, driven scan by scan.

    line = open_bench("line.toml")
    line.run_until(lambda line: line.slot[1].status.MOVE_COMPLETE, within="5 s")
    line.slot[1].press("estop", "100 ms")
    assert line["Trouble"], line.why("Trouble")

A test can read like a story. If a condition does not become true, the error shows the state of the bench.
"""

from __future__ import annotations

TYPE_CHECKING = False  # type checkers treat it as true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .bench import Bench, ObservedLogic
    from .event_log import BenchEvent
    from .moment import NotReachedError
    from .slot import SlotBench

__all__ = ["Bench", "BenchEvent", "NotReachedError", "ObservedLogic", "SlotBench"]


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
