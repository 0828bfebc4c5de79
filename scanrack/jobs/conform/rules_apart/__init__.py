"""Tables of what a 3601 would do without a rule or by another reading."""
