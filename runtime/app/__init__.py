"""The application without a terminal: load a rack, run it, replay, search, drive, answer questions.

| file | what it does |
|---|---|
| `loading` | from the path of a rack to a `Job`: specification, logic, and the files they come from |
| `build` | from a specification to a rack and a CPU |
| `running`, `recording` | a job, run and recorded |
| `attachments`, `trust` | the files that travel with a trace, and which of them may be used |
| `playback`, `replaying`, `levels` | a recording in place of modules, logic or stimuli |
| `hints` | what a program may have meant otherwise |
| `sequence_watch` | where a program's sequences wait |
| `wrapped`, `bare_slots` | a logic around another one; slots without modules |
| `rack_units`, `served_units` | controllers beside a rack, and behind a port |
| `bench/` | a rack in the hands of a test |
| `why/` | which line of a program changed what, and what the modules wait for |
| `drive/` | one module or controller, request by request |
| `fuzz/` | a search for surroundings that break a program |

It knows all rooms below and beside `runtime`, and prints nothing: it returns values, raises exceptions, and
takes callbacks for what a terminal shows meanwhile. `cli` turns them into words and an exit status.
"""
