"""Proofs about programs: one scan as terms, questions about any number of scans, a solver."""
