"""`scanrack debug`: a debug adapter for editors.

    client  --request-->  wire -> adapter -> requests, a table -> a function of the modules below
            <--event----  stopped, continued, output

| file | content |
|---|---|
| `wire`, `protocol` | messages; arguments and errors |
| `requests` | the table of requests; what `initialize` announces |
| `adapter` | a session with a client, and where it stands |
| `starting`, `setting`, `moving`, `looking`, `causes` | what requests do |
| `subject`, `live`, `recorded` | scans by number: of a rack that runs, of a recording |
| `text_subject`, `capture` | the same of a program without rungs, which is run again beside the session |
| `executed_scan`, `cursor` | a scan as it was executed, and a place in it |
| `breakpoints`, `conditions` | what looks for stops after each scan |
| `places`, `variables` | files and lines; scopes and values |
"""
