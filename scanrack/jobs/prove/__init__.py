"""Proofs about a rack's ladder program: `scanrack prove` without its output.

| file | does |
|---|---|
| `subject` | a problem: a rack, program or export with its monitors |
| `proving` | decides all claims of a subject, one at a time |
| `scenario` | turns a run of the prover into operator actions on the rack |
| `on_rack` | runs a scenario on the rack, with the models of its modules |
| `own_run` | runs the rack as its file describes it; everything it reaches is possible |
| `checking` | has another solver check certificates |
| `serving` | proofs for `check`, the preview of an edit, and a search |
| `report`, `page` | answers as JSON, and as a page with the rungs of each scenario |
"""
