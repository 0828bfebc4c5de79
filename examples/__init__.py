"""Racks and programs to begin with; `scanrack new FOLDER --from NAME` copies one."""
