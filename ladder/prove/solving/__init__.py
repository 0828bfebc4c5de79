"""Solving: translates terms for bitwuzla or as SMT-LIB text; consecutive scans; invariants."""
