"""Monitors of a session and of a recording: they make the view of pages, and answer their questions."""
