"""The scan loop: CPU, phases, rack and exchange, forces, listeners, incidents, and the wall clock.

| file | contents |
|---|---|
| `module`, `rack`, `exchange` | contract of a module, slots, images across the backplane |
| `scan`, `phases`, `cpu` | the logic's view, the phases of a scan, running and stopping |
| `faults`, `forces`, `events`, `listeners` | faults of the CPU, held bits, events, and their receivers |
| `incidents`, `exposed`, `key_switch`, `module_fault` | incidents of modules and CPU, data and effect |
| `ahead`, `scans_ahead` | images of the coming scans, computed at once; scans by rows of them |
| `pace`, `realtime`, `options` | wall clock and watchdog, the system's help, options of modules |

Nothing in `runtime` is below it. It knows modules only as the contract in `module`, images and their names
from `io_images`, and neither programs nor recordings: logic is a function, a recorder a listener.
"""
