"""Import and export of Rockwell's files: Studio 5000 (L5X) and RSLogix 500 (SLC)."""
