"""Lines, conditions and reads of a Python program, for explanations."""
