"""The scan loop: CPU, phases, rack and exchange, forces, listeners, incidents, and the clock on the wall.

| file | what it does |
|---|---|
| `module`, `rack`, `exchange` | contract of a module, slots, images across the backplane |
| `scan`, `phases`, `cpu` | what logic sees, the phases of a scan, running and stopping |
| `faults`, `forces`, `events`, `listeners` | what stops, holds, names, marks and hears it |
| `incidents`, `exposed`, `key_switch`, `module_fault` | what happens to modules and CPU, data and effect |
| `ahead`, `scans_ahead` | images of the coming scans, computed at once; scans by rows of them |
| `pace`, `realtime`, `options` | wall clock and watchdog, the system's help, options of modules |

Nothing in `runtime` is below it. It knows modules only as the contract in `module`, images and their names
from `io_images`, and neither programs nor recordings: logic is a function, a recorder a listener.
"""
