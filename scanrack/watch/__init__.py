"""`scanrack watch`: a rack that runs, in the browser.

    scan process                                   monitor process
    play.py, monitor_supervisor.py -> runtime/live  ==ring==> session_monitor.py -> server.py -> pages
                                 ^------- orders -----'

| file or package | content |
|---|---|
| `command` | the command: options in, an exit status out |
| `play`, `recorded_session` | a session from start to end with its branches; a recording |
| `prepared_run`, `editor`, `announcing` | options; a saved program; edits and branches announced |
| `keeper` | starts the monitor process, and again when it dies |
| `server`, `gate`, `text` | files and the socket; access, as tables; the terminal's view |
| `monitors/` | what pages look at and ask; long questions in their own process |
| `history/` | any scan again: images, tags, power, events, lanes, the strip |
| `web/` | the page itself |
"""
