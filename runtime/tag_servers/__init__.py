"""The rack's tags over EtherNet/IP, as a CompactLogix has them, and Modbus: bytes in, bytes out, no sockets.

| file | contents |
|---|---|
| `database.py` | tags by name and number; the bytes that a path names; what clients may write |
| `templates.py` | structures as the template object shows them |
| `tag_snapshot.py` | the instant at which a packet reads and writes; its two passes |
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

A packet runs twice. The first pass notes the bytes that it reads and writes (`Plan`); the scan process
carries all of them out between two scans; the second pass makes the reply from the results (`Instant`).
"""
