"""Loads racks and their programs from files."""
