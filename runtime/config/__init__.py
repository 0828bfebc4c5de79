"""Rack files: TOML to typed objects, and every mistake with its file, line, key, value and what is allowed.

It reads the options of modules off the registry. It builds nothing: that is the application's business.
"""
