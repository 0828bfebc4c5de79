"""Clients of real controllers: a PMC006x3s or a PCL601 at the other end of a serial line or a network.

Reads, and writes that may be repeated, are tried again when the answer is missing or
damaged. A command that starts a motion is never sent twice: when its answer is missing, the
client reads the controller's state.
"""
