"""The application without a terminal: load a rack, run it, replay, search, drive, answer questions.

| room | content |
|---|---|
| `prove/` | claims for every input: verdicts, and scenarios that the rack replays |
| `fuzz/` | a search for inputs and faults that break a program: scenarios, invariants, campaigns |
| `check/`, `bench/`, `drive/` | mistakes without a run; a rack in a test; one module alone |
| `why/` | which line of a program changed what, and what the modules wait for |
| `replay/` | a recording in place of modules, logic or stimuli |
| `run/` | a rack and a CPU from a specification; a job, run, and its result |
| `record/` | a run on record: words, tags, waits of sequences, orders, edits |
| `trust/` | the files that travel with a trace, which of them may be used, and the processes that use them |
| `load/`, `imports/` | from the path of a rack to a `LoadedRack`; rack files for exports |

Each imports only from those below it. The application prints nothing: it returns values, raises exceptions,
and takes callbacks for progress. `front/commands` turns them into words and an exit status.
"""
