"""Collectors for a Python program: functions of the scan, and classes with sequences.

nodes.py        walks over syntax tree nodes, and tests of their kind
reader.py       constants and calls in a program text
functions.py    a function of the scan, with its commands
sequences.py    a class with sequences, with its declarations
calls.py        calls of axis methods in that class
loops.py        loops that never wait
sequence_summaries.py   the commands of each sequence in order, and its locks
numbers.py, conditions.py   ranges and conditions in a program text
scans.py        how a function of the scan uses slots and words
images.py       the expressions in such a function that are slots and images
walk.py         each statement of a function of the scan, with its condition
local_names.py  the meaning of local names at a statement
expression_options.py   the possible values of an expression, one by one
steps.py        steps, and what the program does in them
hand_writes.py  writes to the output words of 3601s
times.py        elapsed times that are used in the wrong unit
names.py        fields and terminals, and their accesses
flow.py         mistakes within one function: conditions, unreachable lines, numbers
scopes.py       names that are never read or that hide other names
attributes.py   names and attributes that do not exist, and calls that do not fit
reals.py        equality comparisons of calculated fractions
counting.py     counters that never count, and subscripts without a bound
chance.py       calls that differ from run to run
"""
