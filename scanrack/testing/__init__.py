"""Parts of the pytest plugin: recordings of failed tests, their reports, and test routines."""
