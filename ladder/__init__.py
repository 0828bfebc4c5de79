"""Logic: programs that a scan loop calls once per scan.

A program is a plain Python function of one argument, the scan: it reads
`scan.slot[1].inputs` and writes `scan.slot[1].outputs`. The scan loop gets it
as a callable and knows nothing of where it came from.
"""
