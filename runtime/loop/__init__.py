"""The scan loop: CPU, phases, rack and exchange, forces, listeners, and the clock on the wall.

It knows modules only as the contract in `module`. Nothing in `runtime` is below it.
"""
