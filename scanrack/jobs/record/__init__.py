"""Records a run: words, tags, waits of sequences, orders and edits."""
