"""The axis of a 3601 in Python, the counterpart of the function blocks in `ladder/blocks/axis3601.rung`.

| file | content |
|---|---|
| `kinds` | one row per command: allowed states, end condition, how it yields |
| `errors` | ErrorID and the exceptions |
| `link`, `evidence` | the link to the module; whether it has accepted a command |
| `command` | one command and its outcome |
| `stop`, `motions`, `blending` | special commands |
| `probe` | the touch probe |
| `drive` | the handshake: eight words in, eight words out |
| `drives` | networked drives: their configuration, and the commands that they lack |
| `plcopen_axis` | `Axis3601` |
"""

from .command import Command
from .errors import AxisError, CommandAborted, ErrorId
from .kinds import State
from .motions import Gear, Registration, Velocity
from .plcopen_axis import Axis3601
from .stop import Stop

__all__ = [
    "Axis3601",
    "AxisError",
    "Command",
    "CommandAborted",
    "ErrorId",
    "Gear",
    "Registration",
    "State",
    "Stop",
    "Velocity",
]
