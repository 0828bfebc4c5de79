"""Compares a real 3601, operated by its controller, with the manual."""
