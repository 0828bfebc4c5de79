"""The bench: a rack with its program and its machine, driven scan by scan.

    line = open_bench("line.toml")
    line.run_until(lambda line: line.slot[1].status.MOVE_COMPLETE, within="5 s")
    line.slot[1].press("estop", "100 ms")
    assert line["Trouble"], line.why("Trouble")

Made for tests that read as a story. The report of a condition that stays false shows the bench at that time.
"""

from .bench import Bench, NotReachedError, ObservedLogic
from .event_log import BenchEvent
from .slot import SlotBench

__all__ = ["Bench", "BenchEvent", "NotReachedError", "ObservedLogic", "SlotBench"]
