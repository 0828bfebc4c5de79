"""A PMC006x3s that acts as a 3601: its link, axis and capabilities."""
