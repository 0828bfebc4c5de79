"""The application without a terminal: loads racks, runs, replays, searches, drives and answers questions.

| package | content |
|---|---|
| `prove/` | properties for all inputs: verdicts, and scenarios that the rack replays |
| `fuzz/` | a search for inputs and faults that break a program: scenarios, invariants, campaigns |
| `check/`, `bench/`, `drive/` | finding mistakes without a run; a rack in a test; a single module |
| `why/` | which line of a program changed a value, and what the modules are waiting for |
| `replay/` | a recording instead of modules, logic or stimuli |
| `run/` | running a job, and its result |
| `record/` | recording a run: words, tags, waits of sequences, operator actions, edits |
| `trust/` | the files in a trace, which of them may be used, and the processes that use them |
| `load/`, `imports/` | making a `LoadedRack` from the path of a rack; rack files for exports |

Each package imports only from packages below it. The application prints nothing. It returns values, raises
exceptions, and calls callbacks for progress. `scanrack/commands` turns these into text and an exit status.
"""

from __future__ import annotations

TYPE_CHECKING = False  # type checkers treat it as true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .bench.opening import open_bench
    from .fuzz.campaign.state import State, read_state, write_state
    from .fuzz.scenarios.kinds import Kind, kinds_for, possible_kinds
    from .fuzz.scenarios.scenario import ContactPress, LostSteps, Scenario, SwitchOffset
    from .load.building import build_cpu, build_rack
    from .load.loading import load_job
    from .load.program import ProgramError, load_program
    from .run.running import JobRun, RunOptions


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
