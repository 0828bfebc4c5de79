"""A generic discrete card: sixteen inputs and sixteen outputs, as a 1769-IQ16 and a 1769-OB16 in one slot.

    Local:2:I.Data      word 0 of the input image, bit n is input n      also I:2.0
    Local:2:O.Data      word 0 of the output image, bit n is output n    also O:2.0

The other seven words of both images are 0. It knows the module contract of the loop and nothing else.
"""
