"""What pages look at and ask: the monitors of a session and of a recording."""
