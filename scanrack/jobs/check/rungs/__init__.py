"""Collectors for a ladder program: rungs and structured text.

operands.py         operands of instructions: their uses, parts and names
number_ranges.py    ranges of numbers, from constants and from values that the program writes
conditions.py       the conditions that instructions and expressions test
walk.py             each instruction with its condition
view.py             a program's instructions, numbers and blocks, as read by the other collectors
accesses.py         variables and their accesses
mistakes.py         mistakes within one rung or statement
structure.py        mistakes in whole routines, add-on instructions and tags
controls.py         mistakes with CONTROLs, counters and bits that several instructions use
loops.py            endless loops, and the counts of loops
subscripts.py       subscripts in loops that are out of bounds
counting.py         counters that no instruction runs, and subscripts without a limit
reals.py            equality comparisons of calculated REALs
add_ons.py          values that add-on instructions read but never write
blocks.py           commands of motion blocks
block_mistakes.py   mistakes in calls of blocks
drive_axes.py       blocks whose axis is a networked drive
calls.py            calls of routines, and instructions that run twice in a scan
timing.py           timers that can't work as intended
terminals.py        terminals and slots that may be missing from the rack
outputs.py          output bits, and the inputs that switch them on
number_options.py   the possible values of a number, one by one
output_writes.py    writes to the output words of 3601s
written_words.py    mistakes in those writes
sent_words.py       commands that are sent as words
steps.py            steps, and what the program does in them
program.py          collects all facts of a program
"""
