"""`scanrack watch`: a running rack in the browser.

    scan process                                   monitor process
    play.py, monitor_supervisor.py -> runtime/live  ==ring==> session_monitor.py -> server.py -> pages
                                 ^------- orders -----'

| file or package | content |
|---|---|
| `command` | the command: options in, an exit status out |
| `play`, `recorded_session` | a session from start to end, with its branches; a recording |
| `editor`, `announcing` | a saved program; announcements of edits and branches |
| `monitor_supervisor` | starts the monitor process, and restarts it when it dies |
| `server`, `gate`, `text` | files and the socket; access rules, as tables; the view in a terminal |
| `monitors/` | the subject of pages, and their questions; long questions in their own process |
| `history/` | the reconstruction of any scan: images, tags, power, events, lanes, the strip |
| `web/` | the page itself |
"""
