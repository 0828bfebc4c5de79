"""Bytes in time: the serial line and its bus, ports, masters, clients, and one codec per protocol.

| file | what it does |
|---|---|
| `wire` | formats, spans of bytes, a bus with devices in virtual time |
| `rtu`, `pcl601_frames`, `pcl601_pdus`, `pcl601_ascii`, `pmc006_frames` | codecs: requests and replies |
| `master`, `adapter_line`, `liveport` | who asks: in virtual time, and on a real port |
| `ports/` | real ports that simulated controllers answer on |
| `clients/` | blocking clients of real controllers, and `probing`, which finds out what answers |
| `hosts`, `serialport` | addresses of networks and serial devices |

It knows the clock of the loop and no controller: a protocol's format of the line is with its codec.
"""
