"""Invariants of every scan: the standard ones and those of users."""
