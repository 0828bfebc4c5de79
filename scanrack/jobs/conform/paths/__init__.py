"""Paths to a module: a controller that owns it, or a trace from a capture."""
