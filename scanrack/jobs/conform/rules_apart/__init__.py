"""Tables of a 3601's behavior without a rule, or by another reading of the manual."""
