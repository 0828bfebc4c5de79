"""Collectors of a program in Python: functions of the scan, and classes with sequences.

nodes.py        the walk over nodes, and what they are
reader.py       constants and calls in a text
functions.py    a function of the scan: its commands
sequences.py    a class with sequences: its declarations
calls.py        calls of an axis in it
loops.py        loops that never wait
sequence_summaries.py   the commands of each sequence in their order, and its locks
numbers.py, conditions.py   ranges and conditions in a text
locks.py        locks, and their orders
scans.py        slots and words of a function of the scan
images.py       what its expressions are: slots, images
steps.py        steps, and what it does in them
names.py        fields and terminals, and what reads and writes them
flow.py         mistakes that show in one function: conditions, lines never reached, numbers
scopes.py       names that nothing reads, or that hide others
attributes.py   names and attributes that do not exist, calls that do not fit
reals.py        calculated fractions that are compared for equality
counting.py     counters that nothing counts, subscripts without a bound
chance.py       calls that differ from run to run
"""
