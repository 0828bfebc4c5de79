"""Draws the events of scenarios at random, near the changes in earlier runs."""
