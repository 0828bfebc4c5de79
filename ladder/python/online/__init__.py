"""Online edits of logic in Python: fields keep their values, each sequence continues at its `await`.

| file | content |
|---|---|
| `held` | what a rebuilt frame takes over from the old frame: waits, iterators, open `with` blocks |
| `suspended` | a waiting frame: its `await`, its locals and what its open blocks hold |
| `points` | the awaits of a function by path in the syntax tree and text; their counterparts after an edit |
| `locals_fit` | whether a frame has the locals that the edited function would have |
| `resumed` | a function rebuilt to begin at one of its awaits |
| `edition` | the source and the functions of a class |
| `conditions` | the functions that a wait holds |
| `fields` | fields set and forced from outside |
| `field_plan` | what an edit does to the fields |
| `placing` | the frames of a sequence in edited code |
| `editing` | the whole class: parts, sequences, and the edit itself |

A frame can't be moved to other code. So the edited function is compiled again, in a form that begins at
the matching `await`; it takes over the locals, the iterators, the `with` blocks and the wait of the waiting
frame. Whatever can't be taken over for certain is refused by name, before anything has changed.
`docs/decisions/0017-edits-of-sequences.md` has the reasons.
"""
