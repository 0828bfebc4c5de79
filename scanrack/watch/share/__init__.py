"""`scanrack share`: a recording and its page in one file."""
