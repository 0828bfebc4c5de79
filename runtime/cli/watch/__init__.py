"""`scanrack watch`: a rack that runs, in the browser.

    scan process                                   monitor process
    command.py, keeper.py -> runtime/live  ==ring==> monitor.py -> server.py -> pages
                                 ^------- orders -----'

| file | what it is for |
|---|---|
| `command.py` | the command: options in, an exit status out |
| `keeper.py` | starts the monitor process, and starts it again when it dies |
| `monitor.py` | the monitor process: rows in, pages and questions served |
| `server.py` | files and the socket; the only file that imports `websockets` |
| `gate.py` | who may come in: names of hosts, origins, headers, files, as tables |
| `page.py` | one open page: what it was shown last, what it may ask |
| `hello.py` | what a page is told of a rack once |
| `recent.py` | the latest rows, by scan |
| `strip.py` | edges and envelopes from rows |
| `shadow.py` | runs scans of a ladder program again: tags and power of any of them |
| `web/` | the page itself |
"""
