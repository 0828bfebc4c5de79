"""The scan loop: CPU, phases, rack and exchange, forces, listeners, injected faults, and the wall clock.

| file | contents |
|---|---|
| `module`, `rack`, `exchange` | module contract, slots, image exchange across the backplane |
| `scan`, `phases`, `cpu` | the logic's view, the phases of a scan, running and stopping |
| `faults`, `forces`, `events`, `listeners` | CPU faults, forced bits, events, and the receivers of events |
| `incidents`, `exposed`, `key_switch`, `module_fault` | injected faults of modules and CPU |
| `ahead`, `scans_ahead` | images of upcoming scans, computed in one go; scans that use these images |
| `pace`, `realtime`, `module_options` | wall clock and watchdog, real-time requests, module options |

This is the lowest layer of `runtime`. It accesses modules only through the contract in `module`, and takes
images and their names from `io_images`. It does not depend on programs or traces: logic is a function, and a
recorder is a listener.
"""
