"""A recording in place of modules, logic or stimuli."""
