"""The application without a terminal: load a rack, run it, replay, search, drive, answer questions.

It knows all rooms. It prints nothing; `cli` turns its answers into words.
"""
