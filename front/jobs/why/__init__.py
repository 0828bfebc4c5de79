"""Why: which line of a Python program changed a value, after which inputs, and what the modules wait for.

| file | does |
|---|---|
| `journal` | what a bench keeps of its scans |
| `past` | a recording up to a scan: since when a bit has its value |
| `waits` | what a 3601 waits for, read from its images |
| `reads`, `lines`, `conditions` | of a traced scan: inputs read, lines that change something, around them |
| `following`, `again` | runs the program again on the recorded inputs, and traces the scans in question |
| `telling`, `answer` | sentences |
| `senders`, `named` | of a class of `Logic`: what its axes send and for which line, its names |
| `moment`, `of_trace` | the scan of a question; questions about a trace |

In other scans nothing of this runs, except the journal of a bench. `fuzz` uses `lines`, too.
"""
