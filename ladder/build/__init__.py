"""From rungs in Python or text to a checked, lowered program."""
