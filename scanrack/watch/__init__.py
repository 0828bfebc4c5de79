"""`scanrack watch`: a running rack in the browser.

    scan process                                   monitor process
    play.py, monitor_supervisor.py -> runtime/live  ==ring==> session_monitor.py -> server.py -> pages
                                 ^------ actions -----'

| file or package | content |
|---|---|
| `command` | the command: options in, an exit status out |
| `play`, `recorded_session` | a session with its branches; a recording |
| `editor`, `announcing` | edits of the program; announcements of edits and branches |
| `monitor_supervisor` | starts the monitor process, and restarts it when it dies |
| `server`, `gate`, `text` | files and the socket; tables of access rules; the view in a terminal |
| `monitors/` | the data of pages, and answers to their questions; long questions have their own process |
| `history/` | reconstruction of any scan: images, tags, power, events, lanes, the strip |
| `web/` | the page |
"""
