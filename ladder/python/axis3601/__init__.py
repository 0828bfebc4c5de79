"""The axis of a 3601 in Python: the function blocks of `ladder/blocks/axis3601.rung`, word for word.

| file | does |
|---|---|
| `kinds` | one row for each command: in which states it is allowed, what ends it, how it yields |
| `errors` | ErrorID, and what is raised |
| `link`, `evidence` | the link to the module; whether it has taken a command |
| `command` | one command and its outcome |
| `stop`, `motions`, `blending` | commands with something of their own |
| `probe` | the touch probe |
| `drive` | the handshake: eight words in, eight words out |
| `axis` | `Axis3601` |
"""

from .axis import Axis3601
from .command import Command
from .errors import AxisError, CommandAborted, ErrorId
from .kinds import State
from .motions import Gear, Registration, Velocity
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
