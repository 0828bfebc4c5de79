"""Random programs with sequences, random edits of them, and their runs scan by scan.

A program is a tree of statements; an edit changes one of its lines, drops some or adds some. A run notes all
that its program has done in each scan: images, fields, waits and locals.
"""

from __future__ import annotations

import copy
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scanrack.jobs import load_program
from scanrack.ladder.python.sequences import fields_of
from sequence_bench import SequenceBench

HEAD = """\
from scanrack import *
from scanrack.io_images.image import Image
from scanrack.ladder.python.sequences import Wait

SETUP = Configuration.from_image(Image({setup}))
PAUSE = "6 ms"
STEP = {step}


def dwell_ms(n: int) -> Wait[None]:
    return dwell(f"{{n}} ms")


class Plant(Logic):
    axis = Axis3601(1, SETUP)
    one = Input("Local:2:I.Data.0")
    two = Input("Local:2:I.Data.1")
    late = OnDelay("{delay} ms")
    zone = Lock()
    a: Output = Output("Local:2:O.Data.0")
    b: Output = Output("Local:2:O.Data.1")
    c: Output = Output("Local:2:O.Data.2")
    d: Output = Output("Local:2:O.Data.3")
    count = 0
    sum = 0
    stops = {stops}

    def every_scan(self) -> None:
        self.late(self.one)
        self.d = self.late{every}

    def odd(self) -> bool:
        return self.count % 2 == {odd}
"""

AWAITS = (
    'await dwell("{n} ms")',
    "await dwell(PAUSE)",
    "await self.one.rises",
    "await self.two.falls",
    "await until(lambda: self.count > {n})",
    "await until(lambda: self.one or self.two)",
    "await until(self.odd)",
    'await steady(lambda: not self.two, "{n} ms")',
    'await first_of(self.one.on, dwell("{n} ms"))',
    "await self.axis.set_position({n})",
    'await first_of(self.axis.run(1000, acceleration=10, deceleration=10), dwell("{n} ms"))',
    "await self.part({n})",
    'await all_of(self.part({n}), self.other(), dwell("4 ms"))',
)

PLAIN = (
    "self.a = not self.a",
    "self.b = self.odd()",
    "self.c = {n} % 2 == 1",
    "self.count += {n}",
    "self.sum += self.count * {n}",
    "x = {n}",
    "x = self.count + {n}",
    "self.sum += STEP",
)

READS = ("self.sum += x", "self.c = x % 2 == 0", "self.count = x", "self.b = x > {n}")

BLOCKS = (
    "if self.odd():",
    "if self.count % 3 != {n}:",
    "while self.count % 7 < {n} and self.turns():",
    "for x in self.stops:",
    "for x in range({n}):",
    "for x in ({n}, 3, 4):",
    "for i, x in enumerate(self.stops):",
    "async with self.zone:",
    "try:",
    "try: # handled",
    "try: # late",
    "match self.count % 2:",
)

Tree = list[Any]
"""Statements: texts, or a head with its blocks."""


class Author:
    """Writes programs and edits with a seed."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)

    def program(self) -> dict[str, Any]:
        parts = {name: self.block(depth) for name, depth in (("first", 3), ("second", 2), ("part", 2))}
        parts["other"] = self.block(1)
        return {**parts, "step": 2, "delay": 8, "stops": "(1, 2, 5)", "every": "", "odd": 0}

    def block(self, depth: int) -> Tree:
        length = self.dice.randint(1, 4)
        return [self.statement(depth) for _ in range(length)] + [self.some(AWAITS[:6])]

    def statement(self, depth: int) -> Any:
        kind = self.dice.random()
        if depth and kind < 0.35:
            return [self.some(BLOCKS), self.block(depth - 1), self.block(depth - 1)]
        return self.some(AWAITS if kind < 0.65 else PLAIN if kind < 0.9 else READS)

    def some(self, texts: tuple[str, ...]) -> str:
        return self.dice.choice(texts).replace("{n}", str(self.dice.randint(1, 6)))

    def edit(self, program: dict[str, Any]) -> dict[str, Any]:
        """Return an edited copy."""
        edited = copy.deepcopy(program)
        kind = self.dice.random()
        if kind < 0.2:
            name, value = self.dice.choice(
                [
                    ("step", 3),
                    ("delay", 12),
                    ("stops", "(1, 2, 5, 6)"),
                    ("every", " or self.odd()"),
                    ("odd", 1),
                ]
            )
            edited[name] = value
            return edited
        tree = edited[self.dice.choice(("first", "first", "second", "part", "other"))]
        while inner := [each for each in tree if isinstance(each, list)]:
            if self.dice.random() < 0.4:
                break
            tree = self.dice.choice(self.dice.choice(inner)[1:])
        place = self.dice.randrange(len(tree))
        if kind < 0.5:
            tree.insert(self.dice.randint(0, len(tree)), self.statement(1))
        elif kind < 0.7 and len(tree) > 1 and isinstance(tree[place], str):
            del tree[place]
        elif isinstance(tree[place], str):
            tree[place] = self.statement(0)
        else:
            tree[place][0] = self.some(BLOCKS)
        return edited


def text_of(program: dict[str, Any], setup: Sequence[int]) -> str:
    """Return a program as Python."""
    lines = [HEAD.format(setup=list(setup), **{k: v for k, v in program.items() if isinstance(v, str | int)})]
    lines.append("    def turns(self) -> bool:\n        self.sum += 1\n        return self.sum % 5 != 0\n")
    for name in ("first", "second"):
        lines.append(
            f"    @sequence\n    async def {name}(self) -> None:\n        x = 1\n        while True:"
        )
        lines += ["            try:", *written(program[name], 16)]
        lines += ["            except (AxisError, WaitTimeout):", '                await dwell("4 ms")']
        lines.append("            self.count += 1\n")
    for name, head in (("part", "self, n: int"), ("other", "self")):
        lines.append(f"    async def {name}({head}) -> None:\n        x = 2")
        lines += [*leaves(program[name], 8), "        self.sum += 1\n"]
    return "\n".join(lines)


def leaves(tree: Tree, depth: int) -> list[str]:
    """Return a helper's body; helpers call no helpers."""
    texts = written(tree, depth)
    return [each.replace("self.part(", "dwell_ms(").replace("self.other()", "dwell_ms(3)") for each in texts]


def written(tree: Tree, depth: int) -> list[str]:
    pad, lines = " " * depth, []
    for each in tree:
        if isinstance(each, str):
            lines.append(pad + each)
            continue
        head, body, other = each
        inner, more = written(body, depth + 4), written(other, depth + 4)
        if head.startswith("try"):
            lines += [pad + "try:", *inner]
            if "handled" in head:
                lines += [f"{pad}    raise ValueError({len(inner)})", f"{pad}except ValueError as error:"]
                lines += [f"{pad}    self.sum += error.args[0]", *more]
            else:
                lines += [pad + "finally:", f"{pad}    self.sum += 3"]
                lines += more if "late" in head else []
        elif head.startswith("match"):
            deeper = written(body, depth + 8)
            lines += [
                pad + head,
                f"{pad}    case 0:",
                *deeper,
                f"{pad}    case _:",
                f"{pad}        self.sum += 4",
            ]
        else:
            lines += [pad + head, *inner]
            if head.startswith("if") and len(more) % 2:
                lines += [pad + "else:", *more]
    return lines


class Run:
    """A run of a program with the inputs of a seed."""

    def __init__(self, folder: Path, text: str, seed: int) -> None:
        self._folder, self._editions = folder, 0
        self.bench = SequenceBench(self.load(text))
        self._dice = random.Random(seed)
        self.scans: list[object] = []
        self.images: list[object] = []

    def load(self, text: str) -> Any:
        """Load a program from a file of its own name."""
        path = self._folder / "plant.py"
        path.write_text(text, encoding="utf-8")
        return load_program(str(path)).function

    def scan(self, scans: int) -> None:
        for _ in range(scans):
            if self._dice.random() < 0.15:
                self.bench.press(self._dice.randint(0, 1), self._dice.random() < 0.5)
            self.bench.scan()
            images = tuple(
                tuple(slot.inputs) + tuple(slot.outputs) for slot in self.bench.rack.slots.values()
            )
            self.images.append((images, tuple(fields_of(self.bench.logic).items())))
            self.scans.append((self.images[-1], *map(state_of, self.bench.sequences)))


def state_of(sequence: Any) -> object:
    """Return what a sequence has done and has: its steps, its wait, the locals of its frames."""
    frames, work = [], sequence._work
    while getattr(work, "cr_frame", None) is not None:
        values = {name: value for name, value in work.cr_frame.f_locals.items() if isinstance(value, int)}
        frames.append((work.cr_code.co_name, tuple(sorted((k, v) for k, v in values.items() if k[0] != "."))))
        work = work.cr_await
    return sequence.resumed, sequence.waits_for, tuple(frames)
