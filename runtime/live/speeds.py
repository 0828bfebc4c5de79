"""The speeds of a session, as multiples of real time."""

SPEED_LEAST, SPEED_MOST = 0.01, 1000.0

MAX = "max"
"""Replaces the factor if a session runs as fast as possible."""
