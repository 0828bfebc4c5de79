"""Scenarios: events of a rack with their times, as data and as text."""
