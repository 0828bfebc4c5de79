"""Ways to a module: a controller that owns it, or a trace of a capture."""
