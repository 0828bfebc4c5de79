"""Random function block diagrams: back ends in lockstep, and booleans against an evaluation of their own.

SCANRACK_DIAGRAMS is the number of diagrams of blocks, 300 by default.
"""

import os
import random

import pytest
from amounts import amount
from l5x_files import block, document, ladder, program, reference, sheets, tag, task, wire
from scanrack.ladder.model.predefined.process_types import ARRAYS, PROCESS
from scanrack.ladder.model.types import BOOL
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.trial import Work, lockstep

PARTS = 10
GATES_OF_PART = amount(20)
DIAGRAMS = int(os.environ.get("SCANRACK_DIAGRAMS", amount(300, few=20)))

INPUTS = ("A", "B", "C")
GATES = {"BAND__F": 2, "BOR__F": 2, "BXOR__F": 2, "BNOT__F": 1}
OF_TWO = ("SourceA", "SourceB")
BLOCKS = {
    "ADD": ("FBD_MATH", OF_TWO, "Dest"),
    "SUB": ("FBD_MATH", OF_TWO, "Dest"),
    "MUL": ("FBD_MATH", OF_TWO, "Dest"),
    "DIV": ("FBD_MATH", OF_TWO, "Dest"),
    "MOD": ("FBD_MATH", OF_TWO, "Dest"),
    "SEL": ("SELECT", ("In1", "In2", "?SelectorIn"), "Out"),
    "HLL": ("HL_LIMIT", ("In", "HighLimit", "LowLimit"), "Out"),
    "SCL": ("SCALE", ("In", "InRawMax", "InRawMin", "InEUMax", "InEUMin"), "Out"),
    "MUX": ("MULTIPLEXER", ("In1", "In2", "Selector"), "Out"),
    "ABS": ("FBD_MATH_ADVANCED", ("Source",), "Dest"),
    "ADD__F": ("", OF_TWO, "Dest"),
    "DIV__F": ("", OF_TWO, "Dest"),
    "LES": ("FBD_COMPARE", OF_TWO, "?Dest"),
    "GEQ__F": ("", OF_TWO, "?Dest"),
    "LIM": ("FBD_LIMIT", ("LowLimit", "Test", "HighLimit"), "?Dest"),
    "BAND": ("FBD_BOOLEAN_AND", ("?In1", "?In5"), "?Out"),
    "BOR__F": ("", ("?In1", "?In2"), "?Out"),
    "BNOT": ("FBD_BOOLEAN_NOT", ("?In",), "?Out"),
    "TONR": ("FBD_TIMER", ("?TimerEnable", "?Reset", "PRE"), "?DN"),
    "TOFR": ("FBD_TIMER", ("?TimerEnable", "PRE"), "ACC"),
    "CTUD": ("FBD_COUNTER", ("?CUEnable", "?CDEnable", "?Reset"), "ACC"),
    "OSRI": ("FBD_ONESHOT", ("?InputBit",), "?OutputBit"),
    "SETD": ("DOMINANT_SET", ("?Set", "?Reset"), "?Out"),
    "BTDT": ("FBD_BIT_FIELD_DISTRIBUTE", ("Source", "SourceBit", "Length", "DestBit", "Target"), "Dest"),
    "DFF": ("FLIP_FLOP_D", ("?D", "?Clear", "?Clock"), "?Q"),
}
"""Type of the tag, inputs and output of each block; those with ? are bits."""


def process_block(chance, name):
    """Return the same of a block of process control, with a random part of its pins."""
    members = PROCESS[name].members
    border = next(place for place, each in enumerate(members) if each.name == "EnableOut")
    pins = [f"{'?' * (each.type is BOOL)}{each.name}" for each in members]
    inputs = [each for each in pins[1:border] if chance.random() < min(1.0, 6 / border)]
    return PROCESS[name].name, inputs, chance.choice(pins[border + 1 :])


@pytest.fixture
def controller(tmp_path):
    def read(content, tags, rate=0):
        text = document(
            tags=[tag(name, *kind.strip("]").split("[")) for name, kind in tags.items()],
            programs=[program("P", ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", content))],
            tasks=[task("T", "P", kind="PERIODIC" if rate else "CONTINUOUS", rate=rate)],
        )
        path = tmp_path / "machine.L5X"
        path.write_text(text, encoding="utf-8")
        found = import_l5x(path)
        assert (found.report.objects, found.report.refused, found.report.lost) == ([], [], [])
        return found.controller

    return read


def gates(chance):
    """Return random gates: the type, and for each input a tag or a gate, and whether of the scan before."""
    made: list[tuple[str, list[tuple[str | int, bool]]]] = []
    behind: list[set[int]] = []
    for number in range(chance.randrange(1, 12)):
        name = chance.choice(list(GATES))
        sources = [chance.choice([*INPUTS, *range(number)] if number else INPUTS) for _ in range(GATES[name])]
        made.append((name, [(each, False) for each in sources]))
        behind.append({number}.union(*(behind[each] for each in sources if isinstance(each, int))))
    for number, (name, sources) in enumerate(made):
        later = [each for each in range(number + 1, len(made)) if number in behind[each]]
        if later and name in ("BAND__F", "BOR__F") and chance.random() < 0.6:
            sources.append((chance.choice(later), True))
    return made


def content_of(made, chance):
    """Return the elements of gates at random places, each with an output of its own."""
    ids = {name: 100 + number for number, name in enumerate(INPUTS)}
    parts = [reference("IRef", ids[name], name) for name in INPUTS]
    for number, (name, sources) in enumerate(made):
        parts.append(block(name, number, x=chance.randrange(900), y=chance.randrange(900)))
        parts.append(reference("ORef", 200 + number, f"Q{number}") + wire(f"{number}.Out", 200 + number))
        pins = ("In",) if len(sources) == 1 else ("In1", "In2", "In3")
        for pin, (source, before) in zip(pins, sources, strict=False):
            start = ids.get(source, f"{source}.Out")
            parts.append(wire(start, f"{number}.{pin}", feedback=before))
    return "".join(parts)


def evaluated(made, inputs, before):
    """Return the outputs of gates from inputs and the outputs of the scan before."""
    now: list[bool] = []
    for name, sources in made:
        values = [
            inputs[each] if isinstance(each, str) else before[each] if late else now[each]
            for each, late in sources
        ]
        results = {
            "BAND__F": all(values),
            "BOR__F": any(values),
            "BXOR__F": sum(values) == 1,
            "BNOT__F": not values[0],
        }
        now.append(results[name])
    return now


@pytest.mark.sampled
@pytest.mark.parametrize("part", range(5))
def test_random_gates_compute_what_their_wires_say(controller, part):
    for seed in range(part * 20, part * 20 + GATES_OF_PART):
        chance = random.Random(seed)
        made = gates(chance)
        tags = dict.fromkeys([*INPUTS, *(f"Q{number}" for number in range(len(made)))], "BOOL")
        logic = controller(content_of(made, chance), tags)
        for engine in (logic.compile(), logic.interpret()):
            expected, values = [False] * len(made), random.Random(seed)
            for _ in range(6):
                inputs = {name: values.random() < 0.5 for name in INPUTS}
                for name, value in inputs.items():
                    engine.tags[name] = value
                engine.step()
                expected = evaluated(made, inputs, expected)
                assert [engine.tags[f"Q{number}"] for number in range(len(made))] == expected, seed


def blocks(chance):
    """Return the content and the tags of a diagram of random blocks, some enabled by wires."""
    parts = [reference("IRef", key, each) for key, each in enumerate(("Bit", "N", "R", "2", "-0.5"))]
    tags = {"Bit": "BOOL", "N": "DINT", "R": "REAL"}
    outputs = {True: ["0"], False: ["1", "2", "3", "4"]}
    for number in range(10, 10 + chance.randrange(2, 12)):
        name = chance.choice([*BLOCKS, *PROCESS])
        kind, pins, output = BLOCKS[name] if name in BLOCKS else process_block(chance, name)
        if kind:
            tags[f"T{number}"] = kind
        arrays = {each: f"T{number}{each}" for each in ARRAYS.get(name, ())}
        tags |= dict.fromkeys(arrays.values(), "REAL[4]")
        parts.append(block(name, number, f"T{number}" if kind else "", x=chance.randrange(900), **arrays))
        wanted = [each for each in pins if not kind or chance.random() < 0.8]
        if kind and chance.random() < 0.2:
            wanted.append("?EnableIn")
        for pin in wanted:
            source = chance.choice(outputs[pin.startswith("?")])
            parts.append(wire(source, f"{number}.{pin.lstrip('?')}"))
        made = f"{number}.{output.lstrip('?')}"
        outputs[output.startswith("?")].append(made)
        if chance.random() < 0.3:
            target = "Bit" if output.startswith("?") else chance.choice(["N", "R"])
            parts.append(reference("ORef", 100 + number, target) + wire(made, 100 + number))
    return "".join(parts), tags


@pytest.mark.sampled
@pytest.mark.parametrize("part", range(PARTS))
def test_random_blocks_do_the_same_on_both_back_ends(controller, part):
    """Every diagram runs in a task of its own rate, or in a continuous one."""
    for seed in range(part, DIAGRAMS, PARTS):
        chance = random.Random(seed)
        content, tags = blocks(chance)
        outcome = lockstep(controller(content, tags, rate=chance.choice((0, 1, 2))), Work(8))
        assert (outcome.scans, outcome.difference, outcome.fault) == (True, "", ""), seed
