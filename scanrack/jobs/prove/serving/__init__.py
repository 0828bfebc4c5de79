"""Proofs for other commands.

| file | serves |
|---|---|
| `judging` | `scanrack check`: proofs of its findings |
| `effects` | the preview of an edit: the values that it can change |
| `aims` | `scanrack fuzz`: dead parts of a program, and scenarios that switch a contact or coil on |
| `stuck` | `scanrack fuzz`: questions to the solver when a search finds nothing new |
"""
