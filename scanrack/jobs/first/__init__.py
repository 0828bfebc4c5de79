"""The first run of an export: conditions it waits for, inputs that never changed, modules not simulated."""
