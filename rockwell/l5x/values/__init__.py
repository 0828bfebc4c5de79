"""Data of an L5X: types, and values in their four notations."""
