"""Small programs with a sequential function chart, and what their tags are scan by scan."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from hypothesis import strategies as st
from scanrack.ladder import LadderLogic, Program
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.chart import Qualifier
from scanrack.ladder.run.engine import Engine

_STEP = re.compile(r"^\s*(?:INITIAL_)?STEP (\w+)", re.MULTILINE)
_STOP = re.compile(r"^\s*STOP (\w+)", re.MULTILINE)
_ACTION = re.compile(r"^\s*ACTION (\w+)", re.MULTILINE)
_TRANSITION = re.compile(r"^\s*TRANSITION (\w+)", re.MULTILINE)


def text_of(chart: str, *, tags: str = "", options: str = "", more: str = "") -> str:
    """Return a program whose routine Seq is a chart; tags of its elements are declared."""
    declared = [
        f"TAG {name} : {kind}"
        for pattern, kind in (
            (_STEP, "SFC_STEP"),
            (_STOP, "SFC_STOP"),
            (_ACTION, "SFC_ACTION"),
            (_TRANSITION, "BOOL"),
        )
        for name in dict.fromkeys(pattern.findall(chart))
    ]
    own = [f"TAG {each}" for each in tags.split(";") if each.strip()]
    head = f"PROGRAM chart\n{f'CHARTS {options}' if options else ''}\n"
    return "\n".join([head, *declared, *own, "ROUTINE Seq SFC", chart, "END", more, ""])


def program_of(chart: str, *, tags: str = "", options: str = "", more: str = "") -> Program:
    """Return the program of `text_of`."""
    found = parse_program(text_of(chart, tags=tags, options=options, more=more))
    assert isinstance(found, Program)
    return found


class BothEngines:
    """A program in both back ends, compared after every scan."""

    def __init__(self, program: LadderLogic) -> None:
        self.compiled, self.interpreted = program.compile(), program.interpret()

    def step(self, inputs: Mapping[str, object] = {}, ms: float = 10) -> Engine:
        """Set tags and do one scan."""
        for each in (self.compiled, self.interpreted):
            for name, value in inputs.items():
                each.tags[name] = value
            each.step(ms)
        assert values(self.compiled) == values(self.interpreted)
        return self.compiled


def values(engine: Engine) -> dict[str, object]:
    """Return all values of an engine's memory."""
    return {name: cell.cell_contents for name, cell in engine.memory.cells.items()}


def told(program: Program, names: str, scans: int, **at: Mapping[int, object]) -> dict[str, list[Any]]:
    """Return the values of tags after each scan of 10 ms; `at` has inputs by scan."""
    both = BothEngines(program)
    found: dict[str, list[Any]] = {name: [] for name in names.split()}
    for scan in range(scans):
        engine = both.step({name: value[scan] for name, value in at.items() if scan in value})
        for name, listed in found.items():
            listed.append(engine.tags[name])
    return found


def marks(listed: list[Any]) -> str:
    """Return bits as text.

    >>> marks([False, True])
    '01'
    """
    return "".join(str(int(bool(each))) for each in listed)


BATCH = """
NOTE Makes <one> batch
INITIAL_STEP Idle
END_STEP
STEP Fill
    ACTION Open N
        Valve := Full & Open.Q;
    END_ACTION
    ACTION Stir S;
END_STEP
STEP Heat
END_STEP
STEP Drain
    ACTION Stir R;
END_STEP
STOP Done
TRANSITION T0 FROM Idle TO Fill, Heat
    Full
END_TRANSITION
TRANSITION T1 FROM Fill, Heat TO Drain
    Fill.DN
END_TRANSITION
TRANSITION T2 FROM Drain TO Idle
    Full
END_TRANSITION
TRANSITION T3 FROM Drain TO Done
    1
END_TRANSITION
"""
"""Steps, a simultaneous branch, a selection, actions of three kinds, and a stop."""


# --- random charts

OPTIONS = ("CURRENT UNTIL_FALSE", "MOST_RECENT INITIAL", "DONT_SCAN PROGRAMMATIC AUTOMATIC")
INPUTS = ("In0", "In1", "In2", "In3")
RANDOM_TAGS = "; ".join(
    [*(f"{each} : BOOL" for each in (*INPUTS, "Reset", "Pause", "Resume")), "N : DINT", "Out : BOOL"]
)
MAIN = """ROUTINE Main
XIC(Reset)SFR(Seq,S1);
XIC(Pause)SFP(Seq,Paused);
XIC(Resume)SFP(Seq,Executing);
JSR(Seq,0);
END
"""


class _Made:
    """The elements of a random chart so far."""

    def __init__(self, draw: st.DrawFn) -> None:
        self.draw = draw
        self.steps: list[str] = []
        self.stored: list[str] = []
        self.transitions: list[str] = []
        self._actions = 0

    def step(self) -> str:
        """Add a step with actions; return its name."""
        name = f"S{len(self.steps) + 1}"
        lines = [f"{'STEP' if self.steps else 'INITIAL_STEP'} {name}"]
        if self.draw(st.booleans()):
            lines.append(f"PRE := {self.draw(st.sampled_from((0, 10, 20)))} + N - N;")
        lines += [line for _ in range(self.draw(st.integers(0, 2))) for line in self._action()]
        self.steps.append("\n".join([*lines, "END_STEP"]))
        return name

    def _action(self) -> list[str]:
        if self.stored and self.draw(st.integers(0, 3)) == 0:
            return [f"ACTION {self.draw(st.sampled_from(self.stored))} R;"]
        self._actions += 1
        name = f"A{self._actions}"
        qualifier = self.draw(st.sampled_from([each.value for each in Qualifier if each.value != "R"]))
        if Qualifier(qualifier).is_stored:
            self.stored.append(name)
        preset = self.draw(st.sampled_from((0, 10, 30)))
        body = self.draw(st.sampled_from(("", f"N := N + {self._actions};", f"Out [:=] {name}.Q;")))
        head = f"ACTION {name} {qualifier} PRE := {preset}"
        return [head, body, "END_ACTION"] if body else [f"{head};"]

    def link(self, sources: Sequence[str], targets: Sequence[str]) -> None:
        """Add a transition."""
        bits = st.sampled_from((*INPUTS, *(f"NOT {each}" for each in INPUTS), f"{sources[0]}.DN", "1"))
        head = f"TRANSITION T{len(self.transitions) + 1} FROM {', '.join(sources)} TO {', '.join(targets)}"
        self.transitions.append(f"{head}\n{self.draw(bits)}\nEND_TRANSITION")

    def path(self, depth: int = 0) -> tuple[str, str]:
        """Add a path; return its first and last step."""
        first = last = self.step()
        for _ in range(self.draw(st.integers(0, 2 - depth))):
            kind = self.draw(st.sampled_from(("step", "selection", "both")))
            legs = [self.path(depth + 1) for _ in range(1 if kind == "step" else 2)]
            end = self.step()
            if kind == "both":
                self.link([last], [begin for begin, _ in legs])
                self.link([each for _, each in legs], [end])
            else:
                for begin, each in legs:
                    self.link([last], [begin])
                    self.link([each], [end])
            last = end
        return first, last


@st.composite
def charts(draw: st.DrawFn) -> str:
    """Random programs: a chart of branches within branches, called by a routine with SFR and SFP."""
    made = _Made(draw)
    first, last = made.path()
    end = draw(st.sampled_from((first, "Done"))) if last != first else "Done"
    made.link([last], [end])
    stop = ["STOP Done"] if end == "Done" else []
    options = " ".join(draw(st.sampled_from(words.split())) for words in OPTIONS)
    chart = "\n".join([*made.steps, *stop, *made.transitions])
    return text_of(chart, tags=RANDOM_TAGS, options=options, more=MAIN).replace(
        "PROGRAM chart", "PROGRAM chart MAIN Main"
    )


def inputs_of(number: int) -> dict[str, object]:
    """Return the inputs of a scan from a number below 512; SFR, SFP are rare."""
    bits = {name: bool(number >> place & 1) for place, name in enumerate(INPUTS)}
    rare = number >> 4
    return {**bits, "Reset": rare == 31, "Pause": rare == 30, "Resume": rare in (0, 1, 2)}
