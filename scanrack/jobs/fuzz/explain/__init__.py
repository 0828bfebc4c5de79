"""Explains the results of a search: point of no return, cause, coverage, rules that never fired."""
