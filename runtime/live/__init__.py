"""A rack that is watched and operated while it runs.

    scan loop -> Tap -> Ring, in shared memory -> a monitor in another process
                  ^                                   |
                  `------- actions, one by one -------'

| file | contents |
|---|---|
| `shared_memory.py` | memory that two processes share |
| `ring.py` | scans, events and snapshots to another process, without a lock and without waiting |
| `actions.py` | operator actions as data, checked when they are made |
| `operator_actions.py` | applies and announces actions that change the rack |
| `session.py` | pause, step, speed, breakpoints; the loop around the CPU |
| `tap.py` | the listener between the scan loop and the ring |

The scan loop never waits for the monitor. Operator actions take effect between two scans. Each action is
recorded with the number of the following scan, so that the session can be repeated.
"""
