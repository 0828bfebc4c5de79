"""Generic cards: Rockwell's digital and analog inputs and outputs, listed in `io_images.cards`.

They depend on the module contract of the loop, and on the machine of a stepper that operates a cam.
"""
