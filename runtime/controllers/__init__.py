"""Simulated controllers: what is at the far end of a line.

`pcl601/` and `pmc006/` each have a controller (registers, instructions, motion, stored program) and a line
device that turns bytes and instants into calls of it. A stored program meets its controller in a protocol
(`pcl601.stored.Axis601`, `pmc006.interpreter.Host`), so that neither file imports the other.

They know the codecs and buses of `line`, machines and kinematics. They do not know who asks: an adapter, a
client in another process and a test are the same to them.
"""
