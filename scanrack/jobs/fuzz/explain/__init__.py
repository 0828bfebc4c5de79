"""Explains the results of a search: point of no return, cause, coverage, and unfired rules."""
