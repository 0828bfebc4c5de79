"""Structures and words that every controller has."""
