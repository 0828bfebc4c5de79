"""Explains the results of a search: point of no return, cause of a failure, coverage, unfired rules."""
