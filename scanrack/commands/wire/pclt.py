"""Stored programs of the PCL601, for `scanrack check` and `scanrack device pcl601 program list`."""

from __future__ import annotations

from itertools import accumulate

from scanrack.io_images.pcl601.program import CAPACITY_BYTES, Program, format_step


def listing(program: Program) -> str:
    """Return a program line by line, with address, size in bytes and instruction."""
    addresses = accumulate((step.size for step in program.steps), initial=0)
    return "\n".join(
        f"{address:5}  {step.size:2}  {format_step(step)}"
        for address, step in zip(addresses, program.steps, strict=False)
    )


def summary(program: Program) -> str:
    """Return the memory size of a program."""
    count = len(program.steps)
    return f"{count} instructions, {program.size} of {CAPACITY_BYTES} bytes"
