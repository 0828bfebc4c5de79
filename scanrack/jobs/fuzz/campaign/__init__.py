"""A long search: rounds in processes, saved on disk, with confirmed failures."""
