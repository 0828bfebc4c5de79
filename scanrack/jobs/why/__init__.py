"""Why: the line of a Python program that changed a value, its inputs, and the waits of the modules.

| file | contents |
|---|---|
| `journal` | the scans of a bench |
| `past` | a recording up to a scan: the age of a bit's value |
| `waits` | the wait of a 3601, read from its images |
| `input_reads`, `lines`, `conditions` | of a traced scan: inputs read, lines that change a value |
| `input_replay`, `traced_run` | the program again on recorded inputs, its scans in question traced |
| `sentences`, `answer` | sentences |
| `chain`, `chains` | causes through images and modules, through Python, and into other racks |
| `senders`, `class_names` | of a class of `Logic`: commands of its axes and their lines, its names |

In other scans nothing of this runs, except the journal of a bench. `fuzz` uses `lines`, too.
"""
