"""Operator panels: buttons, lamps and numbers that users build, in a file beside the rack."""
