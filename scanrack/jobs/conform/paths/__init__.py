"""Paths to a module, through the controller that owns it or a trace from a capture."""
