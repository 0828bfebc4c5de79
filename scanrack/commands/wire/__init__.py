"""Commands for controllers on a line: serve, drive, ports, probe, PCL601 and PMC006."""
