"""Recordings being written."""
