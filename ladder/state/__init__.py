"""A program ready to run: lowered, its memory, its tasks, its faults."""
