"""Files that travel with a trace, permission to use them, and processes that use them."""
