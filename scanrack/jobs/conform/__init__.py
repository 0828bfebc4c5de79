"""A real 3601 behind its controller, held against the manual: scenes, unknown instants, verdicts."""
