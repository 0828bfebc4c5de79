"""Logic in plain Python: sequences, and the axis of a 3601."""
