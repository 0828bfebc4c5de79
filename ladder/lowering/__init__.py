"""Build a checked, lowered program from rungs in Python or text."""
