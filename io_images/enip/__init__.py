"""EtherNet/IP explicit messages [ODVA volumes 1 and 2; 1756-PM020, Logix data access], as tables and data.

| file | contents |
|---|---|
| `codes.py` | numbers of types, services, statuses |
| `frames.py` | frames of the encapsulation and their items |
| `paths.py` | paths of requests: names, subscripts, numbers |
| `listing.py` | a server's tags and their types, and the layout of both in bytes |
"""
