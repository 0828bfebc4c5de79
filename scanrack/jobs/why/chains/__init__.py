"""Chains of causes beyond the rack's images.

`program` has the lines of Python, `partners` the racks beside, `of_run` the chain in a recorded run.
"""
