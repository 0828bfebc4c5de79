"""Terms in a solver: translation, bitwuzla, text for others, scans one after the other, invariants."""
