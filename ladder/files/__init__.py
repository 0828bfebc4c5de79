"""Programs in files: `.rung`, `.st`, `.steps`."""
