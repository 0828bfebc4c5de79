"""Modules for slots: the simulated 3601, adapters that make other devices act as a 3601, drives, and cards.

Any class that satisfies `loop.module.Module` is a module. To add one, write

1. a folder with the module and a `record.py` that defines its `RECORD`, see `record.ModuleRecord`; 2. a line
in `registry.OWN`; 3. its folder in `packages` of pyproject.toml.

Rack files, addresses, traces, `show`, `query`, `drive`, `fuzz` and the bench read the record. Modules depend
on controllers, lines, machines and the module contract of the loop, but not on the CPU, rack files or traces.
"""
