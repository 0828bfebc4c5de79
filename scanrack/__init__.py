"""scanrack: a PLC rack in software for stepper controllers.

These are the names that a program, a test or a notebook needs. Each is imported on first use, so `import
scanrack` is fast. Everything else is in the packages `scanrack.io_images`, `scanrack.ladder`,
`scanrack.rockwell`, `scanrack.runtime`, `scanrack.traces` and `scanrack.jobs`.

>>> from scanrack import Move, MoveKind
>>> list(Move(MoveKind.RELATIVE, 4000, speed=5000, acceleration=20, deceleration=10).to_image())
[2, 0, 4, 0, 5, 0, 20, 10]
"""

# No module is imported here: under `python -m scanrack` the current folder still leads the search path.
TYPE_CHECKING = False  # type checkers treat it as true

if TYPE_CHECKING:  # the public names: type checkers import these lines, `_homes` reads them
    from typing import Any

    from scanrack.io_images import Image as Image
    from scanrack.io_images import strategies as strategies
    from scanrack.io_images.amci3601 import Acceleration as Acceleration
    from scanrack.io_images.amci3601 import BlendSegment as BlendSegment
    from scanrack.io_images.amci3601 import Configuration as Configuration
    from scanrack.io_images.amci3601 import Direction as Direction
    from scanrack.io_images.amci3601 import FindHome as FindHome
    from scanrack.io_images.amci3601 import Firmware as Firmware
    from scanrack.io_images.amci3601 import Hold as Hold
    from scanrack.io_images.amci3601 import Idle as Idle
    from scanrack.io_images.amci3601 import Manual as Manual
    from scanrack.io_images.amci3601 import Move as Move
    from scanrack.io_images.amci3601 import MoveKind as MoveKind
    from scanrack.io_images.amci3601 import PresetPosition as PresetPosition
    from scanrack.io_images.amci3601 import ResetErrors as ResetErrors
    from scanrack.io_images.amci3601 import StatusView as StatusView
    from scanrack.io_images.amci3601.bits import InputBit as InputBit
    from scanrack.jobs.bench import Bench as Bench
    from scanrack.jobs.bench.opening import open_bench as open_bench
    from scanrack.jobs.fuzz.invariants.goals import maximize as maximize
    from scanrack.jobs.fuzz.invariants.goals import sometimes as sometimes
    from scanrack.jobs.fuzz.invariants.invariants import always as always
    from scanrack.jobs.fuzz.invariants.invariants import eventually as eventually
    from scanrack.jobs.fuzz.invariants.invariants import never as never
    from scanrack.jobs.fuzz.invariants.scan_view import Snapshot as Snapshot
    from scanrack.jobs.load.loading import LoadedRack as LoadedRack
    from scanrack.jobs.load.loading import load_rack as load_rack
    from scanrack.jobs.run.result import RunResult as RunResult
    from scanrack.jobs.run.result import run as run
    from scanrack.ladder import ADD as ADD
    from scanrack.ladder import BOOL as BOOL
    from scanrack.ladder import COP as COP
    from scanrack.ladder import COUNTER as COUNTER
    from scanrack.ladder import CTD as CTD
    from scanrack.ladder import CTU as CTU
    from scanrack.ladder import DINT as DINT
    from scanrack.ladder import DIV as DIV
    from scanrack.ladder import EQU as EQU
    from scanrack.ladder import GEQ as GEQ
    from scanrack.ladder import GRT as GRT
    from scanrack.ladder import INT as INT
    from scanrack.ladder import JSR as JSR
    from scanrack.ladder import LEQ as LEQ
    from scanrack.ladder import LES as LES
    from scanrack.ladder import LIM as LIM
    from scanrack.ladder import LINT as LINT
    from scanrack.ladder import LREAL as LREAL
    from scanrack.ladder import MOV as MOV
    from scanrack.ladder import MUL as MUL
    from scanrack.ladder import NEQ as NEQ
    from scanrack.ladder import ONS as ONS
    from scanrack.ladder import OSF as OSF
    from scanrack.ladder import OSR as OSR
    from scanrack.ladder import OTE as OTE
    from scanrack.ladder import OTL as OTL
    from scanrack.ladder import OTU as OTU
    from scanrack.ladder import REAL as REAL
    from scanrack.ladder import RES as RES
    from scanrack.ladder import RTO as RTO
    from scanrack.ladder import SINT as SINT
    from scanrack.ladder import STRING as STRING
    from scanrack.ladder import SUB as SUB
    from scanrack.ladder import TIMER as TIMER
    from scanrack.ladder import TOF as TOF
    from scanrack.ladder import TON as TON
    from scanrack.ladder import UDINT as UDINT
    from scanrack.ladder import XIC as XIC
    from scanrack.ladder import XIO as XIO
    from scanrack.ladder import Controller as Controller
    from scanrack.ladder import Program as Program
    from scanrack.ladder import read_program as read_program
    from scanrack.ladder.lowering.python_rungs import RungMaker as RungMaker
    from scanrack.ladder.python.axis3601 import Axis3601 as Axis3601
    from scanrack.ladder.python.axis3601 import AxisError as AxisError
    from scanrack.ladder.python.axis3601 import CommandAborted as CommandAborted
    from scanrack.ladder.python.axis3601 import ErrorId as ErrorId
    from scanrack.ladder.python.axis3601 import State as State
    from scanrack.ladder.python.sequences import Abort as Abort
    from scanrack.ladder.python.sequences import Counter as Counter
    from scanrack.ladder.python.sequences import DownCounter as DownCounter
    from scanrack.ladder.python.sequences import Fall as Fall
    from scanrack.ladder.python.sequences import Input as Input
    from scanrack.ladder.python.sequences import InputWord as InputWord
    from scanrack.ladder.python.sequences import Lock as Lock
    from scanrack.ladder.python.sequences import Logic as Logic
    from scanrack.ladder.python.sequences import OffDelay as OffDelay
    from scanrack.ladder.python.sequences import OnDelay as OnDelay
    from scanrack.ladder.python.sequences import Output as Output
    from scanrack.ladder.python.sequences import OutputWord as OutputWord
    from scanrack.ladder.python.sequences import Pulse as Pulse
    from scanrack.ladder.python.sequences import Rise as Rise
    from scanrack.ladder.python.sequences import Wait as Wait
    from scanrack.ladder.python.sequences import WaitTimeout as WaitTimeout
    from scanrack.ladder.python.sequences import all_of as all_of
    from scanrack.ladder.python.sequences import dwell as dwell
    from scanrack.ladder.python.sequences import first_of as first_of
    from scanrack.ladder.python.sequences import sequence as sequence
    from scanrack.ladder.python.sequences import steady as steady
    from scanrack.ladder.python.sequences import until as until
    from scanrack.ladder.python.sequences import within as within
    from scanrack.runtime.config.rackspec import RackSpec as RackSpec
    from scanrack.runtime.config.rackspec import SlotSpec as SlotSpec
    from scanrack.runtime.loop.cpu import Cpu as Cpu
    from scanrack.runtime.loop.faults import CpuFault as CpuFault
    from scanrack.runtime.loop.rack import Rack as Rack
    from scanrack.runtime.loop.scan import LogicScan as LogicScan
    from scanrack.runtime.machine.spec import MachineSpec as MachineSpec
    from scanrack.runtime.modules.amci3601 import Amci3601 as Amci3601
    from scanrack.traces.compare import compare as compare
    from scanrack.traces.query import query as query
    from scanrack.traces.read.arrays import read_columns as read_columns
    from scanrack.traces.read.reader import Scan as Scan
    from scanrack.traces.read.reader import Trace as Trace
    from scanrack.traces.read.reader import open_trace as open_trace

    __version__: str
    __loader__: Any


try:  # in a checkout, the other packages are beside this folder
    __loader__.path_stats(__path__[0] + "/../pyproject.toml")
    __path__.append(__path__[0][: -len("/scanrack")])
except (AttributeError, OSError):  # installed, or in an archive
    pass


def __getattr__(name: str) -> object:
    """Import a public name when it is first used; later uses find it in the module."""
    if name == "__all__":
        return list(_homes())
    value = _imported_name(name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(_homes())


_known_homes: dict[str, tuple[str, str]] = {}


def _homes() -> dict[str, tuple[str, str]]:
    """Return the module of each public name and its name in the module, read from the imports above."""
    if not _known_homes:
        import re

        # not `get_source`, which the loader of pytest lacks: pytest loads a package that has a plugin
        text = __loader__.get_data(__file__).decode("utf-8")
        rows = re.findall(r"^    from (\S+) import (\w+) as (\w+)$", text, re.MULTILINE)
        _known_homes.update(
            {
                "__version__": ("", ""),
                **{name: (module, original_name) for module, original_name, name in rows},
            }
        )
    return _known_homes


def _imported_name(name: str) -> object:
    """Return the object, module or version that a public name refers to."""
    from importlib import import_module

    homes = _homes()
    if name == "__version__":
        return import_module("scanrack.io_images.versions").distribution_version(__name__)
    if name not in homes:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; {_nearest(name, list(homes))}")
    module_name, original_name = homes[name]
    module = import_module(module_name, __name__)
    if hasattr(module, original_name):
        return getattr(module, original_name)
    return import_module(f"{module_name}.{original_name}", __name__)  # a module, not a name in it


def _nearest(name: str, names: list[str]) -> str:
    from difflib import get_close_matches

    matches = get_close_matches(name, names, n=1)
    return f"did you mean {matches[0]}?" if matches else f"its names are {', '.join(names)}"
