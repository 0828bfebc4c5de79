"""Mutation testing of the command layer: what `benchmarks/mutants.py` is made of."""
