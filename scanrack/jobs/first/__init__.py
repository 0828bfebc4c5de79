"""The first run of an export, with a report of its conditions, unchanged inputs and modules."""
