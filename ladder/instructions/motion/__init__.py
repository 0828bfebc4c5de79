"""Motion instructions and their axes."""
