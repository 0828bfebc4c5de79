"""Rack files: TOML to typed objects; every mistake has its file, line, key, value and the allowed values.

`rackspec` has one class per table of the file, pydantic throughout; `rackfile` reads a file and words its
mistakes, with the lines that `tomllines` finds. Names, options and words of a module come from its
record in `modules.registry`, so that a new module needs nothing here.

It knows modules, controllers and machines, since a specification that exists is sound: its modules can be
made, its forces have addresses. It runs nothing.
"""
