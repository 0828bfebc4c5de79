"""Writes files completely or not at all, locks them, and keeps earlier versions."""
