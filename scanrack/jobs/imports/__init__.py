"""Turns exports of Rockwell programs into rack files."""
