"""The speeds of a session: how many times real time."""

SPEED_LEAST, SPEED_MOST = 0.01, 1000.0

MAX = "max"
"""In place of a factor: as fast as the program runs."""
