"""Generic cards: digital and analog inputs and outputs, as Rockwell sells them; `kinds` is the table.

They know the module contract of the loop and the machine of a stepper that operates a cam.
"""
