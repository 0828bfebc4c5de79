"""Chains of causes that go beyond the rack's images.

`program`, `unwritten` and `waiting` explain values of a Python program, and `partners` explains consumed
tags. `of_run` makes the chain in a recorded run.
"""
