"""Clients for real devices: a PMC006x3s or a PCL601 on a serial line or a network.

A client repeats a read, or a write without side effects, when the answer is missing or damaged. It never
repeats a command that starts a motion: when the answer is missing, it reads the device's state.
"""
