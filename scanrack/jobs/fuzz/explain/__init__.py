"""What a search says: when a failure became inevitable, what its cause was, what was not reached."""
