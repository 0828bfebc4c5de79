"""Terms of Booleans, whole numbers and floats: operations, and evaluation for many values at once."""
