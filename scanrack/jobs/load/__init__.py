"""Loads a job from the path of a rack: the specification, the logic, and their files."""
