"""What sits in a slot: the simulated 3601, adapters that make other controllers answer as one, plain cards.

A module is whatever satisfies `loop.module.Module`. To add one:

1. a folder with the module and a `record.py`, whose `RECORD` says what the rest of the house has to know of
   it: name, factory, names of its words and bits, status view, live port, traits, capabilities;
2. a line in `registry.MODULES`;
3. its folder in `packages` of pyproject.toml.

Rack files, addresses, recording, `show`, `query`, `drive`, `fuzz` and the bench read it off the record;
`discrete/` is the smallest example. Modules know controllers, lines, machines and the module contract of the
loop. None knows the CPU, a rack file or a recording.
"""
