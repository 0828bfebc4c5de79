"""Scenarios: what happens to a rack and when, as data and as text."""
