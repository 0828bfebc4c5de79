"""A long search: rounds over processes, kept on disk, finds confirmed."""
