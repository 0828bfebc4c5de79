"""What the pytest plugin does: recordings of failed tests, their reports, and test routines."""
