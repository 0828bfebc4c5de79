"""Serves simulated devices in real time: controllers on a line, networked drives, the 3601 as remote I/O."""
