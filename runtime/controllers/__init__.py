"""Simulated devices at the far end of a line.

`pcl601/` and `pmc006/` each have a controller (registers, instructions, motion, stored program) and its line,
which turns bytes and instants into calls to the controller. A stored program accesses its controller through
a protocol (`pcl601.stored.Axis601`, `pmc006.interpreter.ProgramHost`).
"""
