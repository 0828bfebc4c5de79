"""What the text of a Python program says about a value."""
