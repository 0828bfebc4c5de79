"""What happens in time: from the commands down to the scan loop.

Time is an integer number of nanoseconds since power-up, everywhere. Nothing here but `loop.pace` knows the
clock on the wall, and nothing but `cli` and `app` knows the rooms of programs and recordings.

| folder | what it is for |
|---|---|
| `cli/` | commands: options in, words and an exit status out |
| `app/` | load, run, record, replay, fuzz, drive, bench: the application, usable without a terminal |
| `live/` | a rack that is watched and operated while it runs |
| `config/` | rack files to objects |
| `modules/` | what sits in a slot, one registry |
| `controllers/` | what is at the far end of a line |
| `line/` | bytes in time: bus, ports, masters, clients, one codec per protocol |
| `machine/` | what a module is bolted to |
| `kinematics/` | motions as closed forms of time |
| `loop/` | CPU, phases, exchange, rack, forces, listeners, pace |

Imports point downward in this table and nowhere else; a contract in pyproject.toml holds us to it, and
docs/decisions/0010-layers-of-the-runtime.md says why the cuts are where they are.
"""
