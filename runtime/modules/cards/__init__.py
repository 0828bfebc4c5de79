"""Generic cards: Rockwell's digital and analog inputs and outputs, listed in `io_images.cards`.

They depend on the loop's module contract, and on the machine of any stepper that operates a cam.
"""
