"""What sits in a slot: the simulated 3601, and adapters that make other controllers answer as one.

`registry` has one record per module. Modules know controllers, lines and machines; none knows a rack file.
"""
