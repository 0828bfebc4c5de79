"""Suffixes of the files of programs."""

SUFFIX = ".rung"
"""Suffix of program files."""

STRUCTURED_SUFFIX = ".st"
"""Suffix of structured text files."""

STEPS_SUFFIX = ".steps"
"""Suffix of step files."""
