"""The rack's tags over EtherNet/IP (as a CompactLogix) and Modbus, as bytes in and out, without sockets.

| file | contents |
|---|---|
| `database.py` | tags by name and number; targets of paths; tags that clients may write |
| `templates.py` | structures in the template object |
| `tag_snapshot.py` | the values that a packet reads and writes at one instant; the two passes of a packet |
| `exchange.py` | operations of packets, and their results, as bytes between two processes |
| `tag_services.py` | reading and writing tags |
| `objects.py` | identity, listing, templates, clock, change counters |
| `data_files.py` | PCCC: the data files of SLC 500 and MicroLogix |
| `router.py` | requests to objects, batches, routes |
| `connections.py` | forward open and close |
| `session.py` | a TCP connection: frames, one session |
| `tag_paths.py` | tag names in text form |
| `mapped_tags.py`, `register_map.py` | tags as Modbus coils and registers |
| `modbus_session.py` | a TCP connection of Modbus |
| `setup.py` | tags and settings of a server; the sessions of each protocol |

A packet is processed twice. The first pass records its reads and writes (`Plan`). The scan process carries
them out between two scans. The second pass builds the reply from the results (`Instant`).
"""
