"""The terminal: output in text or JSON, progress, messages and exit statuses."""
