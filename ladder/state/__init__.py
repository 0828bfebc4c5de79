"""A program that is ready to run: its lowered form, memory, tasks and faults."""
