"""Exports of Rockwell's programs to rack files."""
