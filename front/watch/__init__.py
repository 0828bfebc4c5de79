"""`scanrack watch`: a rack that runs, in the browser.

    scan process                                   monitor process
    play.py, keeper.py -> runtime/live  ==ring==> session_monitor.py -> server.py -> pages
                                 ^------- orders -----'

| file | what it is for |
|---|---|
| `command.py` | the command: options in, an exit status out |
| `keeper.py` | starts the monitor process, and starts it again when it dies |
| `monitor.py` | what pages look at |
| `session_monitor.py`, `trace_monitor.py` | of a rack that runs; of a recording |
| `questions.py` | what a page may ask |
| `server.py` | files and the socket; the only file that imports `websockets` |
| `play.py`, `recorded.py` | a session from start to end with its branches; a recording |
| `prepared.py` | the options, and a run that is ready to begin |
| `editor.py` | the program's file is saved: loaded beside the scans, taken over between two |
| `announcing.py` | announces edits and branches to the monitor |
| `text.py` | the terminal's view |
| `gate.py` | access: names of hosts, origins, headers, files, as tables |
| `page.py` | one open page: what it was shown last, how much it may ask |
| `hello.py`, `catalog.py` | the first message to a page: rack and program |
| `picture.py`, `strip.py` | what a frame shows of a scan; edges and envelopes |
| `recent.py`, `timeline.py` | rows by scan: the latest, and those of the recording |
| `event_log.py` | events, and the forces, rules and waiting lines of any scan |
| `recorded_events.py` | the same of a recording, read where a page looks |
| `shadow.py` | runs scans of a ladder program again, for tags and power of any of them |
| `stretch.py` | the programs of a session by scan |
| `indexer.py` | runs all scans of a recording once, for values now and then |
| `lanes.py` | lanes of tags in the timing strip |
| `elsewhere.py`, `why_process.py` | long questions, in a process of their own; why, of a Python program |
| `web/` | the page itself |
"""
