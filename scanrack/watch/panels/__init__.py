"""Operator panels of buttons, lamps and numbers that users build, each in a file beside its rack file."""
