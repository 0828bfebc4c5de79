"""Recordings being read."""
