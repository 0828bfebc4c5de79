"""The scan loop: CPU, phases, rack and exchange, forces, listeners, injected faults, and the wall clock.

| file | contents |
|---|---|
| `module`, `rack`, `exchange` | contract of a module, slots, images across the backplane |
| `scan`, `phases`, `cpu` | the logic's view, the phases of a scan, running and stopping |
| `faults`, `forces`, `events`, `listeners` | faults of the CPU, forced bits, events, and their receivers |
| `incidents`, `exposed`, `key_switch`, `module_fault` | injected faults of modules and CPU |
| `ahead`, `scans_ahead` | images of the coming scans, computed at once; scans that use these images |
| `pace`, `realtime`, `module_options` | wall clock and watchdog, real-time requests, options of modules |

This is the lowest layer of `runtime`. It uses modules only through the contract in `module`, and images and
their names from `io_images`. It does not depend on programs or recordings: logic is a function, a recorder is
a listener.
"""
