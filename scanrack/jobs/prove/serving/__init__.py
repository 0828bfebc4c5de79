"""Proofs for other commands.

| file | serves |
|---|---|
| `judging` | `scanrack check`: proofs of its findings |
| `effects` | the preview of an edit: what it can change |
| `aims` | `scanrack fuzz`: dead parts of a program, and scenarios that switch a contact or coil on |
"""
