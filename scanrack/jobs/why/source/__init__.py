"""Reads explanations from the source text of a Python program."""
