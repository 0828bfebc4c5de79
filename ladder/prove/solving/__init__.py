"""Translates terms for bitwuzla or to SMT-LIB text, models consecutive scans, and finds invariants."""
