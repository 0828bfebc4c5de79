"""Modules for slots: the simulated 3601, adapters that let other controllers act as a 3601, plain cards.

Any class that satisfies `loop.module.Module` is a module. To add one:

1. a folder with the module and a `record.py`, whose `RECORD` has its name, factory, names of its words
   and bits, status view, live port, traits and capabilities;
2. a line in `registry.OWN`;
3. its folder in `packages` of pyproject.toml.

Rack files, addresses, traces, `show`, `query`, `drive`, `fuzz` and the bench read the record.
Modules depend on controllers, lines, machines and the module contract of the loop, but not on the CPU, rack
files or recordings.
"""
