"""The application without a terminal: load a rack, run it, replay, search, drive, answer questions.

| package | content |
|---|---|
| `prove/` | claims for every input: verdicts, and scenarios that the rack replays |
| `fuzz/` | a search for inputs and faults that break a program: scenarios, invariants, campaigns |
| `check/`, `bench/`, `drive/` | mistakes without a run; a rack in a test; one module alone |
| `why/` | which line of a program changed what, and what the modules wait for |
| `replay/` | a recording in place of modules, logic or stimuli |
| `run/` | a rack and a CPU from a specification; a job, run, and its result |
| `record/` | a run on record: words, tags, waits of sequences, orders, edits |
| `trust/` | the files that travel with a trace, which of them may be used, and the processes that use them |
| `load/`, `imports/` | from the path of a rack to a `LoadedRack`; rack files for exports |

Each imports only from those below it. The application prints nothing: it returns values, raises exceptions,
and takes callbacks for progress. `scanrack/commands` turns them into words and an exit status.
"""

from __future__ import annotations

TYPE_CHECKING = False  # a type checker takes it for true

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
