"""The PCL601, simulated down to its serial line."""
