"""One scan of a program as terms: the interpreter's rows on numbers that are not known."""
