"""The terminal: what is printed, where, in which form, and the exit statuses."""
