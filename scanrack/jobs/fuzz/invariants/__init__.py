"""Invariants that are checked in every scan: standard ones and users' own."""
