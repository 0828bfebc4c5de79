"""Parts of the pytest plugin: recordings and reports of failed tests, test routines, and a test kit."""
