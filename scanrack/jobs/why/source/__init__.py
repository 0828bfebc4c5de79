"""The text of a Python program as a source of explanations."""
