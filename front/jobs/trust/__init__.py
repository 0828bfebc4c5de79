"""Files that travel with a trace, which of them may be used, and processes that use them."""
