"""Function block diagrams: sheets to structured text, which both back ends, proofs and `why` know.

| file | content |
|---|---|
| `sheets` | the elements and wires of a routine, and the order in which its blocks run |
| `blocks` | what each block does, as structured text |
| `wire_values` | the text and the type of each output |
| `picture` | where its elements stand, for pages |
| `lowering` | a diagram to the lines of its routine |
"""
