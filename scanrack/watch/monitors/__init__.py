"""Monitors of a session and of a recording, which create the contents of pages and answer their questions."""
