"""The simulation: everything that runs in virtual time, from the scan loop to a watched session.

Time is always an integer number of nanoseconds since power-up. Only `loop.pace` reads the wall clock.

| folder | contents |
|---|---|
| `live/` | a rack that is watched and operated while it runs |
| `tag_servers/` | tag protocols (EtherNet/IP, Modbus, OPC UA), without sockets |
| `config/` | rack files as typed objects |
| `modules/` | the modules that fit into slots, and their registry |
| `controllers/` | simulated devices at the far end of a line |
| `line/` | serial and network lines: bus, ports, masters, clients, one codec per protocol |
| `machine/` | the machine that a module drives |
| `kinematics/` | motions as closed forms of time |
| `loop/` | CPU, phases, exchange, rack, forces, listeners, pace |

Imports point downward in this table; a contract in pyproject.toml checks it.
docs/decisions/0010-layers-of-the-runtime.md explains the layers.
"""

from __future__ import annotations

TYPE_CHECKING = False  # type checkers assume that it is true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .config.rackfile import RackFileError, load_rack_file, parse_rack_file
    from .config.rackspec import RackSpec, SlotSpec
    from .line.wire import Device, LineFormat, SerialBus
    from .live.actions import Edit, Force, Online, Write
    from .loop.cpu import Cpu, CpuFault, CpuMode, ScanFlag
    from .loop.incidents import FaultKind, InjectedFault
    from .loop.pace import Clock, FreeRun, Watchdog
    from .loop.rack import Card, Rack
    from .machine.contacts import Contact
    from .modules.amci3601 import Amci3601, ModuleFault


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
