"""The Anaheim Automation PCL601: its registers, its serial line and its stored programs, as data."""
