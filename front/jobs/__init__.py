"""The application without a terminal: load a rack, run it, replay, search, drive, answer questions.

| file | what it does |
|---|---|
| `loading` | from the path of a rack to a `Job`: specification, logic, and the files they come from |
| `build` | from a specification to a rack and a CPU |
| `running`, `recording` | a job, run and recorded |
| `attachments`, `extracting`, `trust` | the files that travel with a trace, and which of them may be used |
| `owned` | the files of a run, which no output replaces |
| `retaining`, `retained` | tags from run to run |
| `editing`, `editions` | edits of a running program, and their files |
| `repeating`, `tag_orders`, `outside` | orders of a recording, given again; tags that are set from outside |
| `playback`, `replaying`, `levels` | a recording in place of modules, logic or stimuli |
| `hints` | possible mistakes of a program, found in a run |
| `tag_names`, `tag_source` | the tags of a run: their names; one function that reads them |
| `sequence_watch` | where a program's sequences wait |
| `watched_program`, `watched_python`, `watched_machines` | what a monitor gets of a run |
| `launcher` | starts helper processes |
| `limits` | `within`, in logic and for the search |
| `l5x_rack`, `slc_rack`, `toml_text` | rack files for exports |
| `wrapped`, `bare_slots` | a logic around another one; slots without modules |
| `rack_units`, `served_units` | controllers beside a rack, and behind a port |
| `bench/` | a rack in the hands of a test |
| `why/` | which line of a program changed what, and what the modules wait for |
| `check/` | mistakes in a rack, found without a run |
| `drive/` | one module or controller, request by request |
| `fuzz/` | a search for surroundings that break a program |

It knows all rooms below and beside `runtime`, and prints nothing: it returns values, raises exceptions, and
takes callbacks for what a terminal shows meanwhile. `cli` turns them into words and an exit status.
"""
