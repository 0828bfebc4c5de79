"""Tables of what a 3601 might do otherwise: without a rule, or by another reading."""
