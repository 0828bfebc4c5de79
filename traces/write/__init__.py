"""Writing of recordings."""
