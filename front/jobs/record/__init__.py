"""A run on record: words, tags, waits of sequences, orders and edits."""
