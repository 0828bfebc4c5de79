"""Instructions of SLC 500 and MicroLogix controllers [1747-RM001, 1766-RM001].

| file | content |
|---|---|
| `status` | the status file: arithmetic flags, overflow trap, math register |
| `numbers` | arithmetic, moves, scaling, conversions |
| `timing` | timers with a time base, 16-bit counters, RES |
| `files` | copies, shifts, queues, sequencers |
| `messages` | MSG, with its result from a stub |
| `processor` | the status file before and after a scan |
| `rows` | all rows; equal rows are shared with Logix |
"""

from .rows import SLC_SPECS

__all__ = ["SLC_SPECS"]
