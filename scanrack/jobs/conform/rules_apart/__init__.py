"""Tables of a 3601's behavior without a rule, or with another interpretation of the manual."""
