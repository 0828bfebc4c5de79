"""Operator panels with buttons, lamps and numbers that users build, each in a file next to its rack file."""
