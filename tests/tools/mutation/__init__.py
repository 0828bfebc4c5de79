"""Mutation testing of the command layer: what `tests/tools/mutants.py` is made of."""
