"""The language server: what an editor shows of rungs, steps, rack files and programs in Python.

command.py      `scanrack editor lsp`
server.py       the protocol: documents in, diagnostics and answers out; needs the extra `editor`
findings.py     checks of a document, those that run Python in their own process
rungs.py        declarations and instructions at a place of rungs or structured text
racks.py        keys and values at a place of a rack file

All but the server is plain text in, plain text out.
"""
