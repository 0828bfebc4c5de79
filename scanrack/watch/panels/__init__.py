"""Operator panels that users build from buttons, lamps and numbers, in a file beside the rack file."""
