"""EtherNet/IP explicit messages [ODVA volumes 1 and 2; 1756-PM020, Logix data access], as tables and data.

| file | contents |
|---|---|
| `codes.py` | numbers of types, services, statuses |
| `frames.py` | frames of the encapsulation and their items |
| `paths.py` | paths of requests: names, subscripts, numbers |
| `io_frames.py` | paths and packets of class 1 connections |
| `listing.py` | the tags of a server, with their types and bytes |
"""
