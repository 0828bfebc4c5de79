"""Proofs about a rack's ladder program: `scanrack prove` without its output.

| file | does |
|---|---|
| `subject` | a rack, program or export with its monitors, as a problem |
| `proving` | all claims of a subject, one after the other |
| `scenario` | a run of the prover as an operator's orders on the rack |
| `on_rack` | a scenario on the rack, with the models of its modules |
| `own_run` | what the rack does on its own: it is possible |
| `checking` | certificates checked by another solver |
| `serving` | proofs for `check`, the preview of an edit, and a search |
| `report`, `page` | answers as JSON, and as a page with the rungs of each scenario |
"""
