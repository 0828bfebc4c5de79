"""Suffixes of program files."""

SUFFIX = ".rung"
"""Suffix of files with rungs."""

STRUCTURED_SUFFIX = ".st"
"""Suffix of structured text files."""

STEPS_SUFFIX = ".steps"
"""Suffix of step files."""
