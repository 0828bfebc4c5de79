"""Aims a search: draws parts of scenarios at random, near the changes in a run."""
