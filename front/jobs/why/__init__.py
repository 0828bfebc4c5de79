"""Why: the line of a Python program that changed a value, its inputs, and the waits of the modules.

| file | contents |
|---|---|
| `journal` | the scans of a bench |
| `past` | a recording up to a scan: the age of a bit's value |
| `waits` | the wait of a 3601, read from its images |
| `reads`, `lines`, `conditions` | of a traced scan: inputs read, lines that change a value, their conditions
|
| `following`, `again` | runs the program again on the recorded inputs, and traces the scans in question |
| `telling`, `answer` | sentences |
| `senders`, `named` | of a class of `Logic`: commands of its axes and their lines, its names |

In other scans nothing of this runs, except the journal of a bench. `fuzz` uses `lines`, too.
"""
