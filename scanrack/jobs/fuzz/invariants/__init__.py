"""Invariants that are checked in every scan: standard invariants and the users' own."""
