"""Tables of a 3601's behavior without a rule, or under another reading of the manual."""
