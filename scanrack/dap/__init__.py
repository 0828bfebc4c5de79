"""`scanrack debug`: run a debug adapter for editors.

    client  --request-->  wire -> adapter -> requests, a table -> a function of the modules below
            <--event----  stopped, continued, output, breakpoint

| file | content |
|---|---|
| `wire`, `protocol` | messages; arguments and errors |
| `requests` | the table of requests; what `initialize` announces |
| `adapter` | a session with a client, and its current position |
| `starting`, `setting`, `moving`, `looking` | handlers of requests |
| `subject`, `live`, `recorded` | scans by number, of a running rack or of a recording |
| `text_subject`, `capture` | the same for a program without rungs; the program is run again |
| `executed_scan`, `cursor` | a scan as it was executed, and a place in it |
| `breakpoints`, `conditions` | checks for breakpoints after each scan |
| `together` | breakpoints that editor and page share |
| `in_test`, `port_of_tests` | tests of pytest |
| `places`, `variables` | files and lines; scopes and values |
"""
