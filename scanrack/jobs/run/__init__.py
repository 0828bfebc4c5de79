"""Runs and records jobs."""
