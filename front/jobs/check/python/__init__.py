"""Collectors of a program in Python: functions of the scan, and classes with sequences.

reader.py       constants and calls in a text
functions.py    a function of the scan: its commands
sequences.py    a class with sequences: its declarations
calls.py        calls of an axis in it
loops.py        loops that never wait
story.py        the commands of each sequence in their order, and its locks
numbers.py, conditions.py   ranges and conditions in a text
scans.py        slots and words of a function of the scan
names.py        fields and terminals, and what reads and writes them
flow.py         mistakes that show in one function: conditions, lines never reached, chance
"""
