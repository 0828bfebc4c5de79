"""A long search in several processes: it runs in rounds, is saved on disk, and confirms failures."""
