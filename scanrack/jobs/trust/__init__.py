"""The files in a trace, the permission to run them, and helper processes."""
