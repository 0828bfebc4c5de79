"""Collectors of a ladder program: rungs, and structured text.

values.py           ranges of numbers, from constants and from what the program writes
walk.py             each instruction with the condition under which it acts
accesses.py         variables, and what reads and writes them
mistakes.py         mistakes that show in one rung or statement
structure.py        mistakes of routines, add-on instructions and tags as a whole
blocks.py           commands of motion blocks
output_writes.py    writes to the output words of 3601s
program.py          all facts of a program
"""
