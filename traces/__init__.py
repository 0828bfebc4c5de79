"""The flight recorder: schema, recorder and reader of MCAP traces.

This room knows `io_images` and nothing else of ours: the recorder is handed the
rack's memory block, and the loop calls it with scans and events as a listener.
"""
