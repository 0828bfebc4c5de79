"""One scan of a program as terms: the interpreter's instructions run on symbolic values."""
