"""Why: which line of a Python program changed what, after which inputs, and what the modules wait for.

| file | does |
|---|---|
| `journal` | what a bench keeps of its scans |
| `past` | a recording up to a scan: since when a bit is as it is |
| `waits` | what a 3601 waits for, read from its images |
| `reads`, `lines`, `conditions` | of a traced scan: inputs read, lines that change something, around them |
| `following`, `again` | runs the program again on the recorded inputs, and traces the scans in question |
| `telling`, `answer` | sentences |
| `senders`, `named` | of a class of `Logic`: what its axes send and for which line, what its names mean |
| `moment`, `of_trace` | the scan that is asked about; questions about a trace |

Nothing of this runs in a scan that is not asked about, but for the journal of a bench. `lines` serves `fuzz`.
"""
