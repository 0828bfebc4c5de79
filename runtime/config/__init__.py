"""Rack files: TOML to typed objects, and every mistake with its file, line, key, value and what is allowed.

`rackspec` has one class per table of the file, pydantic throughout; `rackfile` reads a file and words its
mistakes, with the lines that `tomllines` finds. What a module is called, takes and names is read off its
record in `modules.registry`, so that a new module needs nothing here.

It knows modules, controllers and machines, since a specification that exists is sound: its modules can be
made, its forces have addresses. It runs nothing; that is the application's business.
"""
