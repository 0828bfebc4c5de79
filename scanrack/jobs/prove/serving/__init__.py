"""What proofs say to others.

| file | serves |
|---|---|
| `judging` | `scanrack check`: what proofs say of its findings |
| `effects` | the preview of an edit: what it can change |
| `aims` | `scanrack fuzz`: what of a program is dead, and a scenario that makes a contact or coil on |
"""
