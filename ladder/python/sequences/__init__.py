"""Logic in plain Python, exact to the scan: sequences that wait for edges, times and motion.

| file | content |
|---|---|
| `waits` | awaitable conditions, times, edges |
| `watch` | the dependencies of a wait |
| `coroutine` | one sequence: a coroutine and its wait |
| `branches` | several waits as one |
| `parts`, `places`, `signals` | declared parts; their places; bits and words of the images |
| `blocks`, `locks` | timers, edges, counters; locks between sequences |
| `declaring`, `mistakes`, `logic` | checks of declarations; statements without effect; the class |
| `generated` | a scan of an instance as one function |

There is no event loop, no thread and no clock: the scan polls each wait, and resumes a sequence when its
wait is over.
"""

from .blocks import Counter, DownCounter, Fall, OffDelay, OnDelay, Pulse, Rise
from .branches import WaitTimeout, all_of, first_of, within
from .coroutine import Abort, Sequence
from .declaring import sequence
from .locks import Lock
from .logic import Logic, fields_of, fresh, parts_of, sequences_of
from .signals import Input, InputWord, Output, OutputWord
from .waits import Wait, dwell, steady, until

__all__ = [
    "Abort",
    "Counter",
    "DownCounter",
    "Fall",
    "Input",
    "InputWord",
    "Lock",
    "Logic",
    "OffDelay",
    "OnDelay",
    "Output",
    "OutputWord",
    "Pulse",
    "Rise",
    "Sequence",
    "Wait",
    "WaitTimeout",
    "all_of",
    "dwell",
    "fields_of",
    "first_of",
    "fresh",
    "parts_of",
    "sequence",
    "sequences_of",
    "steady",
    "until",
    "within",
]
