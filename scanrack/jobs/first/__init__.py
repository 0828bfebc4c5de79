"""The first run of an export: what it waits for, what it never saw, what it wants."""
