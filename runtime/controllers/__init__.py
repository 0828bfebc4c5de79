"""Simulated controllers: the device at the far end of a line.

`pcl601/` and `pmc006/` each have a controller (registers, instructions, motion, stored program) and a line
device that turns bytes and instants into calls of it. A controller runs its stored program, which uses the
controller by a protocol (`pcl601.stored.Axis601`, `pmc006.interpreter.ProgramHost`).
"""
