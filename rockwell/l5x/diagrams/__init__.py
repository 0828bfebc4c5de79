"""Function block diagrams, translated to structured text, which both back ends, proofs and `why` can read.

| file | content |
|---|---|
| `sheets` | the elements and wires of a routine, and the order in which its blocks run |
| `blocks` | what each block does, as structured text |
| `wire_values` | the text and the type of each output |
| `picture` | the places of its elements, for drawing |
| `lowering` | a diagram to the lines of its routine |
"""
