"""Online edits of logic in Python: fields keep their values, each sequence continues at its `await`.

| file | content |
|---|---|
| `held` | what a rebuilt frame takes over from the frame before: waits, iterators, open `with` blocks |
| `suspended` | a waiting frame: its `await`, its locals and what its open blocks hold |
| `points` | the awaits of a function by their path in the syntax tree and their text; their counterparts |
| `locals_fit` | whether the locals of a frame are those that the edited function would have |
| `resumed` | a function that begins at one of its awaits |
| `edition` | the source and the functions of a class |
| `conditions` | the functions that a wait holds |
| `fields` | fields that are set and forced from outside |
| `field_plan` | what an edit does to the fields |
| `placing` | the frames of a sequence in edited code |
| `editing` | the whole class: parts, sequences, and the edit itself |

A frame can't be moved to other code. So the edited function is compiled once more, in a form that begins at
the matching `await`; it takes the locals, the iterators and the `with` blocks of the waiting frame, and its
wait. Whatever can't be taken over for certain is refused by name, before anything has changed.
`docs/decisions/0017-edits-of-sequences.md` has the reasons.
"""
