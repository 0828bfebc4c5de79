"""Online edits of logic in Python: fields keep their values, and each sequence continues at its `await`.

| file | content |
|---|---|
| `held` | objects that a rebuilt frame keeps from the old frame: waits, iterators, open `with` blocks |
| `suspended` | a waiting frame: its `await`, its locals and the objects of its open blocks |
| `points` | the awaits of a function by path in the syntax tree and text; their counterparts after an edit |
| `locals_fit` | whether a frame has the locals that the edited function would have |
| `resumed` | a function rebuilt to begin at one of its awaits |
| `edition` | the source and the functions of a class |
| `conditions` | the functions in a wait |
| `fields` | fields set and forced from outside |
| `field_plan` | the effects of an edit on the fields |
| `placing` | the frames of a sequence in edited code |
| `editing` | the whole class: parts, sequences, and the edit itself |

A frame can't be moved to other code. Therefore the edited function is compiled again, in a form that begins
at the matching `await` with the waiting frame's locals, iterators, `with` blocks and wait. An edit that might
not continue correctly is refused before anything changes. The message names the object.
`docs/decisions/0017-edits-of-sequences.md` explains why.
"""
