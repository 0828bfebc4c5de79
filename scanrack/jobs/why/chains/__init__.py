"""Chains of causes that go beyond the rack's images.

`program` adds the lines of Python, `partners` other racks, and `of_run` the chain in a recorded run.
"""
