"""Commands for racks and their programs: run, check, ladder, L5X, why, fuzz, rules."""
