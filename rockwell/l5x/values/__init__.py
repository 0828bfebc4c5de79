"""Reads the data of an L5X: types, and values in four notations."""
