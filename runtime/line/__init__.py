"""Serial and network lines: bus, ports, masters, clients, and one codec per protocol.

| file | contents |
|---|---|
| `wire` | formats, spans of bytes, a bus with devices in virtual time |
| `rtu`, `pcl601_frames`, `pcl601_pdus`, `pcl601_ascii`, `pmc006_frames` | codecs: requests and replies |
| `master`, `adapter_line`, `liveport` | masters: in virtual time, and on a real port |
| `ports/` | real ports of simulated devices |
| `clients/` | blocking clients of real devices, and `probing`, which finds devices |
| `hosts`, `serialport` | addresses of networks and serial devices |

This package uses the loop's clock and does not import any simulated device. A codec contains its line format.
"""
