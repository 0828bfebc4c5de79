"""`scanrack share`: a recording and its page in a single file."""
