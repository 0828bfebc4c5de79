"""Clients for real use: a PMC006x3s or a PCL601 at the other end of a serial line or a network.

The law of this room: what only reads, or writes what may be written twice, is
tried again when the answer is missing or damaged; what starts a motion is never
sent twice. When its answer is missing, the controller is asked what it is doing.
"""
