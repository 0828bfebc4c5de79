"""The flight recorder: schema, recorder and reader of MCAP traces.

This room knows only `io_images`: the recorder receives the rack's memory block, and
the loop calls it with scans and events as a listener.
"""
