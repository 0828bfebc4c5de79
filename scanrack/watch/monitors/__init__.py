"""Monitors of a session and of a recording, which create what pages show and answer their questions."""
