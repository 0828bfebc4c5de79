"""scanrack: a PLC rack in software for stepper controllers.

These are the names that a program, a test or a notebook needs. Each is imported when it is first used, so
`import scanrack` costs nothing. Everything else is in the rooms: `scanrack.io_images`, `scanrack.ladder`,
`scanrack.rockwell`, `scanrack.runtime`, `scanrack.traces` and `scanrack.jobs`.

>>> from scanrack import Move, MoveKind
>>> list(Move(MoveKind.RELATIVE, 4000, speed=5000, acceleration=20, deceleration=10).to_image())
[2, 0, 4, 0, 5, 0, 20, 10]
"""

# No module is imported here: under `python -m scanrack` the current folder still leads the search path.
TYPE_CHECKING = False  # a type checker takes it for true

if TYPE_CHECKING:  # the names of the front door: type checkers import these lines, `_homes` reads them
    from typing import Any

    from .io_images import Image as Image
    from .io_images import strategies as strategies
    from .io_images.amci3601 import Acceleration as Acceleration
    from .io_images.amci3601 import BlendSegment as BlendSegment
    from .io_images.amci3601 import Configuration as Configuration
    from .io_images.amci3601 import Direction as Direction
    from .io_images.amci3601 import FindHome as FindHome
    from .io_images.amci3601 import Firmware as Firmware
    from .io_images.amci3601 import Hold as Hold
    from .io_images.amci3601 import Idle as Idle
    from .io_images.amci3601 import Manual as Manual
    from .io_images.amci3601 import Move as Move
    from .io_images.amci3601 import MoveKind as MoveKind
    from .io_images.amci3601 import PresetPosition as PresetPosition
    from .io_images.amci3601 import ResetErrors as ResetErrors
    from .io_images.amci3601 import StatusView as StatusView
    from .io_images.amci3601.bits import InputBit as InputBit
    from .jobs.bench import Bench as Bench
    from .jobs.bench.opening import open_bench as open_bench
    from .jobs.fuzz.invariants.goals import maximize as maximize
    from .jobs.fuzz.invariants.goals import sometimes as sometimes
    from .jobs.fuzz.invariants.invariants import always as always
    from .jobs.fuzz.invariants.invariants import eventually as eventually
    from .jobs.fuzz.invariants.invariants import never as never
    from .jobs.fuzz.invariants.scan_view import Snapshot as Snapshot
    from .jobs.load.loading import LoadedRack as LoadedRack
    from .jobs.load.loading import load_rack as load_rack
    from .jobs.run.result import RunResult as RunResult
    from .jobs.run.result import run as run
    from .ladder import ADD as ADD
    from .ladder import BOOL as BOOL
    from .ladder import COP as COP
    from .ladder import COUNTER as COUNTER
    from .ladder import CTD as CTD
    from .ladder import CTU as CTU
    from .ladder import DINT as DINT
    from .ladder import DIV as DIV
    from .ladder import EQU as EQU
    from .ladder import GEQ as GEQ
    from .ladder import GRT as GRT
    from .ladder import INT as INT
    from .ladder import JSR as JSR
    from .ladder import LEQ as LEQ
    from .ladder import LES as LES
    from .ladder import LIM as LIM
    from .ladder import LINT as LINT
    from .ladder import LREAL as LREAL
    from .ladder import MOV as MOV
    from .ladder import MUL as MUL
    from .ladder import NEQ as NEQ
    from .ladder import ONS as ONS
    from .ladder import OSF as OSF
    from .ladder import OSR as OSR
    from .ladder import OTE as OTE
    from .ladder import OTL as OTL
    from .ladder import OTU as OTU
    from .ladder import REAL as REAL
    from .ladder import RES as RES
    from .ladder import RTO as RTO
    from .ladder import SINT as SINT
    from .ladder import STRING as STRING
    from .ladder import SUB as SUB
    from .ladder import TIMER as TIMER
    from .ladder import TOF as TOF
    from .ladder import TON as TON
    from .ladder import UDINT as UDINT
    from .ladder import XIC as XIC
    from .ladder import XIO as XIO
    from .ladder import Controller as Controller
    from .ladder import Program as Program
    from .ladder import read_program as read_program
    from .ladder.lowering.python_rungs import RungMaker as RungMaker
    from .ladder.python.axis3601 import Axis3601 as Axis3601
    from .ladder.python.axis3601 import AxisError as AxisError
    from .ladder.python.axis3601 import CommandAborted as CommandAborted
    from .ladder.python.axis3601 import ErrorId as ErrorId
    from .ladder.python.axis3601 import State as State
    from .ladder.python.sequences import Abort as Abort
    from .ladder.python.sequences import Counter as Counter
    from .ladder.python.sequences import DownCounter as DownCounter
    from .ladder.python.sequences import Fall as Fall
    from .ladder.python.sequences import Input as Input
    from .ladder.python.sequences import InputWord as InputWord
    from .ladder.python.sequences import Lock as Lock
    from .ladder.python.sequences import Logic as Logic
    from .ladder.python.sequences import OffDelay as OffDelay
    from .ladder.python.sequences import OnDelay as OnDelay
    from .ladder.python.sequences import Output as Output
    from .ladder.python.sequences import OutputWord as OutputWord
    from .ladder.python.sequences import Pulse as Pulse
    from .ladder.python.sequences import Rise as Rise
    from .ladder.python.sequences import Wait as Wait
    from .ladder.python.sequences import WaitTimeout as WaitTimeout
    from .ladder.python.sequences import all_of as all_of
    from .ladder.python.sequences import dwell as dwell
    from .ladder.python.sequences import first_of as first_of
    from .ladder.python.sequences import sequence as sequence
    from .ladder.python.sequences import steady as steady
    from .ladder.python.sequences import until as until
    from .ladder.python.sequences import within as within
    from .runtime.config.rackspec import RackSpec as RackSpec
    from .runtime.config.rackspec import SlotSpec as SlotSpec
    from .runtime.loop.cpu import Cpu as Cpu
    from .runtime.loop.faults import CpuFault as CpuFault
    from .runtime.loop.rack import Rack as Rack
    from .runtime.loop.scan import LogicScan as LogicScan
    from .runtime.machine.spec import MachineSpec as MachineSpec
    from .runtime.modules.amci3601 import Amci3601 as Amci3601
    from .traces.compare import compare as compare
    from .traces.query import query as query
    from .traces.read.arrays import read_columns as read_columns
    from .traces.read.reader import Scan as Scan
    from .traces.read.reader import Trace as Trace
    from .traces.read.reader import open_trace as open_trace

    Job, Moment, maximise = LoadedRack, Snapshot, maximize  # old names, see `io_images.renamed`
    __version__: str
    __loader__: Any


def __getattr__(name: str) -> object:
    if name == "__all__":
        return list(_homes())
    if name not in _homes():
        from .io_images.renamed import RENAMED, renamed

        if f"{__name__}.{name}" in RENAMED:
            return renamed(__name__, name)
    found = _find(name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(_homes())


_found_homes: dict[str, tuple[str, str]] = {}


def _homes() -> dict[str, tuple[str, str]]:
    """Return the module of each name, and its name there; the lines above are read once."""
    if not _found_homes:
        import re

        # `get_data`, not `get_source`: pytest, which loads a package that has a plugin, has only that
        text = __loader__.get_data(__file__).decode("utf-8")
        rows = re.findall(r"^    from (\S+) import (\w+) as (\w+)$", text, re.MULTILINE)
        _found_homes.update(
            {"__version__": ("", ""), **{name: (module, there) for module, there, name in rows}}
        )
    return _found_homes


def _find(name: str) -> object:
    from importlib import import_module

    homes = _homes()
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name not in homes:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; {_nearest(name, list(homes))}")
    module, there = homes[name]
    home = import_module(module, __name__)
    return getattr(home, there) if hasattr(home, there) else import_module(f"{module}.{there}", __name__)


def _nearest(name: str, names: list[str]) -> str:
    from difflib import get_close_matches

    close = get_close_matches(name, names, n=1)
    return f"did you mean {close[0]}?" if close else f"its names are {', '.join(names)}"
