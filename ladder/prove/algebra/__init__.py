"""Terms: Booleans, whole numbers and floats, their meaning, and their evaluation for many values at once."""
