"""Terms in a solver: translation, bitwuzla, SMT-LIB text, consecutive scans, invariants."""
