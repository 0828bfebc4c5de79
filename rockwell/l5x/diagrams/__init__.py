"""Translates function block diagrams to structured text, which both back ends, proofs and `why` can read.

| file | content |
|---|---|
| `sheets` | the elements and wires of a routine, and the order in which its blocks run |
| `blocks` | the structured text of each type of block |
| `wire_values` | the text and the type of each output |
| `picture` | the positions of elements, for drawing |
| `lowering` | translates a diagram to the lines of its routine |
"""
