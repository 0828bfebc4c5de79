"""Generic cards: digital and analog inputs and outputs, as Rockwell sells them; `io_images.cards` has them.

They depend on the module contract of the loop, and on the machine of a stepper that operates a cam.
"""
