"""A running program: engine, tag view, online edits."""
