"""A long search in several processes that runs in rounds, is saved on disk, and confirms failures."""
