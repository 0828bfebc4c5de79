"""The scan loop: CPU, phases, rack and exchange, forces, listeners, injected faults, and the wall clock.

| file | contents |
|---|---|
| `module`, `rack`, `exchange` | contract of a module, slots, images across the backplane |
| `scan`, `phases`, `cpu` | the logic's view, the phases of a scan, running and stopping |
| `faults`, `forces`, `events`, `listeners` | faults of the CPU, held bits, events, and their receivers |
| `incidents`, `exposed`, `key_switch`, `module_fault` | incidents of modules and CPU, data and effect |
| `ahead`, `scans_ahead` | images of the coming scans, computed at once; scans by rows of them |
| `pace`, `realtime`, `module_options` | wall clock and watchdog, real-time requests, options of modules |

It is the lowest layer of `runtime`. It uses modules only by the contract in `module`, and images and their
names from `io_images`. It depends on no program and no recording: logic is a function, a recorder a listener.
"""
