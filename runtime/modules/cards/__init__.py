"""Generic cards: digital and analog inputs and outputs, as Rockwell sells them; `io_images.cards` has them.

They know the module contract of the loop and the machine of a stepper that operates a cam.
"""
