"""Generic cards: digital and analog inputs and outputs, as Rockwell sells them; `kinds` is the table.

It knows the module contract of the loop, the machine of a stepper that operates a cam, and nothing else.
"""
