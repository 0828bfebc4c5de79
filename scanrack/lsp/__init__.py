"""The language server for rungs, steps, rack files and Python programs in editors.

command.py      `scanrack editor lsp`
server.py       the protocol: documents in, diagnostics and responses out; needs the extra `editor`
findings.py     checks of a document; checks that run Python use their own process
rungs.py        declarations and instructions at a position in rungs or structured text
racks.py        keys and values at a position in a rack file

All modules except the server take and return plain text.
"""
