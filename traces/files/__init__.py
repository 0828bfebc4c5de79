"""Writing files completely or not at all, locking them, and keeping earlier ones."""
