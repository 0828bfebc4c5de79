"""Simulated devices at the far end of a line.

`pcl601/` and `pmc006/` each have a controller (registers, instructions, motion, stored program) and its line,
which converts bytes and instants to calls of the controller. A stored program uses its controller through a
protocol (`pcl601.stored.Axis601`, `pmc006.interpreter.ProgramHost`).
"""
