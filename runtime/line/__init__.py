"""Bytes in time: the serial line and its bus, ports, masters, clients, and one codec per protocol.

It knows the scan loop's clock and nothing of the controllers at either end.
"""
