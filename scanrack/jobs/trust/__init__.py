"""Handles the files in a trace, the permission to use them, and processes that use them."""
