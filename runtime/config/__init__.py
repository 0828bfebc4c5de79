"""Parses TOML rack files into typed objects; each error names the file, line, key, value and allowed values.

`rackspec` and the `*_tables` have one pydantic class per table of the file. `rackfile` reads a file and
writes its error messages, with the lines that `tomllines` finds. Names, options and words of a module come
from its record in `modules.registry`, so a new module needs no change here.

This package imports modules, controllers and machines to validate a specification: every module can be built,
and every force has an address. It runs nothing.
"""
