"""Sizes of a PNG or SVG picture, in inches unless noted."""

from __future__ import annotations

DPI = 110
WIDTH = 13.0
LEFT, RIGHT = 1.75, 0.25
TOP = 0.72
MARKS, HEAD, POSITION, SPEED, NUMBER, LANE, AXIS, GAP = 0.62, 0.3, 1.5, 0.95, 0.55, 0.2, 0.5, 0.16
"""Heights. HEAD is for the head of a panel without marks, and NUMBER is for a tag's curve."""

PIXELS = round((WIDTH - LEFT - RIGHT) * DPI)
"""Pixels across the time axis."""

EDGE = 0.004
"""Margin at either end of the time axis, as a fraction of its length; it makes pulses at the ends visible."""

POINTS_PER_INCH = 72
LABEL_SIZE, NAME_SIZE = 7.5, 8.0
NAME_LETTERS = 23
"""Number of letters of a name that fit to the left of its lane."""

LETTER = 0.58 * LABEL_SIZE / POINTS_PER_INCH
"""Width of a letter in a label, inches."""
