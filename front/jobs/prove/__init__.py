"""Proofs about a rack's ladder program: `scanrack prove` without its words.

| file | does |
|---|---|
| `subject` | a rack, program or export with its monitors, as a problem |
| `proving` | all claims of a subject, one after the other |
| `scenario` | a run of the prover as an operator's orders on the rack |
| `on_rack` | a scenario on the rack, with the models of its modules |
| `judging` | what proofs say of the findings of `scanrack check` |
| `effects` | what an edit can change |
| `report`, `page` | answers as JSON, and as a page with the rungs of each scenario |
"""
