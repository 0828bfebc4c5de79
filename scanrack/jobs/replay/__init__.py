"""Plays a recording instead of modules, logic or stimuli."""
