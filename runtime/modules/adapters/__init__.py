"""Adapters: other controllers that the 3601's command layer operates, with the same eight words.

    PLC image <-> CommandLayer (the 3601's rules) <-> Axis over a link <-> the controller's line

An adapter is a state machine without I/O: it takes bytes in, puts bytes out, and reports the instant of its
next wake-up. In virtual time its line is a `wire.SerialBus` with a simulated controller at the other end.
"""
