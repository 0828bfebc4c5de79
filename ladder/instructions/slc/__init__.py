"""Instructions as SLC 500 and MicroLogix controllers do them [1747-RM001, 1766-RM001].

| file | does |
|---|---|
| `status` | the status file: arithmetic flags, overflow trap, math register |
| `numbers` | arithmetic, moves, scaling, conversions |
| `timing` | timers with a time base, 16-bit counters, RES |
| `files` | copies, shifts, queues, sequencers |
| `messages` | MSG, whose end a stub describes |
| `processor` | the status file before and after a scan |
| `rows` | all rows; those of Logix that do the same here are taken as they are |
"""

from .rows import SLC_SPECS

__all__ = ["SLC_SPECS"]
