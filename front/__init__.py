"""scanrack: a PLC rack in software for stepper controllers.

These are the names that a program, a test or a notebook needs. Each is imported when it is first used, so
`import scanrack` costs nothing. Everything else is in the rooms: `scanrack.io_images`,
`scanrack.ladder`, `scanrack.runtime` and `scanrack.traces`.

>>> from scanrack import Move, MoveKind
>>> list(Move(MoveKind.RELATIVE, 4000, speed=5000, acceleration=20, deceleration=10).to_image())
[2, 0, 4, 0, 5, 0, 20, 10]
"""

# No module is imported here: under `python -m scanrack` the current folder still leads the search path.
TYPE_CHECKING = False  # a type checker takes it for true

if TYPE_CHECKING:
    from .io_images import Image, strategies
    from .io_images.amci3601 import (
        Acceleration,
        BlendSegment,
        Configuration,
        Direction,
        FindHome,
        Firmware,
        Hold,
        Idle,
        Manual,
        Move,
        MoveKind,
        PresetPosition,
        ResetErrors,
        StatusView,
    )
    from .io_images.amci3601.bits import InputBit
    from .jobs.bench.opening import open_bench
    from .jobs.fuzz import always, never
    from .jobs.fuzz.laws.limits import within
    from .ladder import Program, read_program
    from .ladder.python.axis3601 import Axis3601, AxisError, CommandAborted, ErrorId, State
    from .ladder.python.sequences import (
        Abort,
        Counter,
        DownCounter,
        Fall,
        Input,
        InputWord,
        Lock,
        Logic,
        OffDelay,
        OnDelay,
        Output,
        OutputWord,
        Pulse,
        Rise,
        Wait,
        WaitTimeout,
        all_of,
        dwell,
        first_of,
        sequence,
        steady,
        until,
    )
    from .runtime.config.rackspec import RackSpec
    from .runtime.loop.cpu import Cpu
    from .runtime.loop.rack import Rack
    from .runtime.loop.scan import Scan
    from .runtime.modules.amci3601 import Amci3601
    from .traces.compare import compare
    from .traces.query import query
    from .traces.read.arrays import read_columns
    from .traces.read.reader import open_trace

    __version__: str

__all__ = [
    "Abort",
    "Acceleration",
    "Amci3601",
    "Axis3601",
    "AxisError",
    "BlendSegment",
    "CommandAborted",
    "Configuration",
    "Counter",
    "Cpu",
    "Direction",
    "DownCounter",
    "ErrorId",
    "Fall",
    "FindHome",
    "Firmware",
    "Hold",
    "Idle",
    "Image",
    "Input",
    "InputBit",
    "InputWord",
    "Lock",
    "Logic",
    "Manual",
    "Move",
    "MoveKind",
    "OffDelay",
    "OnDelay",
    "Output",
    "OutputWord",
    "PresetPosition",
    "Program",
    "Pulse",
    "Rack",
    "RackSpec",
    "ResetErrors",
    "Rise",
    "Scan",
    "State",
    "StatusView",
    "Wait",
    "WaitTimeout",
    "__version__",
    "all_of",
    "always",
    "compare",
    "dwell",
    "first_of",
    "never",
    "open_bench",
    "open_trace",
    "query",
    "read_columns",
    "read_program",
    "sequence",
    "steady",
    "strategies",
    "until",
    "within",
]

_HOMES = {
    "io_images": ("Image",),
    "io_images.amci3601": (
        "Acceleration",
        "BlendSegment",
        "Configuration",
        "Direction",
        "FindHome",
        "Firmware",
        "Hold",
        "Idle",
        "Manual",
        "Move",
        "MoveKind",
        "PresetPosition",
        "ResetErrors",
        "StatusView",
    ),
    "io_images.amci3601.bits": ("InputBit",),
    "ladder": ("Program", "read_program"),
    "ladder.python.axis3601": ("Axis3601", "AxisError", "CommandAborted", "ErrorId", "State"),
    "ladder.python.sequences": (
        "Abort",
        "Counter",
        "DownCounter",
        "Fall",
        "Input",
        "InputWord",
        "Lock",
        "Logic",
        "OffDelay",
        "OnDelay",
        "Output",
        "OutputWord",
        "Pulse",
        "Rise",
        "Wait",
        "WaitTimeout",
        "all_of",
        "dwell",
        "first_of",
        "sequence",
        "steady",
        "until",
    ),
    "jobs.bench.opening": ("open_bench",),
    "jobs.fuzz": ("always", "never"),
    "jobs.fuzz.laws.limits": ("within",),
    "runtime.config.rackspec": ("RackSpec",),
    "runtime.loop.cpu": ("Cpu",),
    "runtime.loop.rack": ("Rack",),
    "runtime.loop.scan": ("Scan",),
    "runtime.modules.amci3601": ("Amci3601",),
    "traces.read.arrays": ("read_columns",),
    "traces.compare": ("compare",),
    "traces.query": ("query",),
    "traces.read.reader": ("open_trace",),
}
"""The module that defines each name."""


def __getattr__(name: str) -> object:
    found = _find(name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _find(name: str) -> object:
    from importlib import import_module

    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name == "strategies":
        return import_module(".io_images.strategies", __name__)
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}; {_nearest(name)}")


def _nearest(name: str) -> str:
    from difflib import get_close_matches

    close = get_close_matches(name, __all__, n=1)
    return f"did you mean {close[0]}?" if close else f"its names are {', '.join(__all__)}"
