"""Serves simulated devices in step with the wall clock: controllers on a line, the 3601 as remote I/O."""
