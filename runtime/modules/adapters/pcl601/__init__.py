"""A PCL601 that acts as a 3601: its link, axis and capabilities."""
