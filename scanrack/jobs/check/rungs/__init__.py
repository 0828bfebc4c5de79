"""Collectors of a ladder program: rungs, and structured text.

operands.py         operands of instructions: uses, parts, names
number_ranges.py    ranges of numbers, from constants and from what the program writes
conditions.py       what instructions and expressions decide
walk.py             each instruction with the condition under which it acts
accesses.py         variables, and what reads and writes them
mistakes.py         mistakes that show in one rung or statement
structure.py        mistakes of routines, add-on instructions and tags as a whole
controls.py         mistakes with CONTROLs, counters and bits that several instructions share
loops.py            loops that never end, and what they count
subscripts.py       subscripts that a loop takes out of their array
counting.py         counters that nothing runs, subscripts that nothing limits
reals.py            calculated REALs that are compared for equality
add_ons.py          what the routines of an add-on instruction read, and never write
blocks.py           commands of motion blocks
block_mistakes.py   mistakes in calls of blocks
terminals.py        terminals and slots: whether the rack has them
output_writes.py    writes to the output words of 3601s
written_words.py    what is wrong with them
sent_words.py       commands that are sent as words
steps.py            steps, and what the program does in them
program.py          all facts of a program
"""
