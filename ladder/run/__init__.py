"""One running program: engine, its view for others, edits."""
