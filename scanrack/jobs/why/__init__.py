"""Explanations: the rung or line that changed a value, its inputs, and the waits of the modules.

| file | contents |
|---|---|
| `journal` | the scans of a bench |
| `past` | a recording up to a scan: the last changes of bits |
| `waits`, `drive_waits` | the waits of a 3601 and of a networked drive, read from their images |
| `overrides` | forces, faults, program mode and lost links |
| `input_reads`, `lines`, `conditions` | in a traced scan: the inputs read, the lines that change a value |
| `followed`, `traced_run`, `program_rerun` | repeated runs of the program on recorded inputs |
| `sentences`, `answer` | the text of the answers |
| `bits`, `chain`, `chains` | causes through images and modules, through Python, and into other racks |
| `senders`, `class_names` | for a `Logic` class: its names, and the lines that command its axes |
| `acts`, `trials`, `copies` | changes of inputs and operator actions that would change a value |

Before the first question, only the journal of a bench runs. `fuzz` also uses `lines`.
"""
