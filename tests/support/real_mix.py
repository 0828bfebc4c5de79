"""Whole controllers with the shape of real ones, from a seed: the same document each time.

The shares are those of 8,612 rungs of public exports (`real_rungs`). Several programs and tasks; types of 8
to 300 members, arrays of 1,000 structures; add-ons nested to eight with InOuts of structures and of
elements of arrays; structured text that copies and builds strings in every second routine; aliases.

Any number of scans runs without a major fault, and changes much of the memory: each program counts scans, and
bits of the count are its inputs.
"""

from collections.abc import Iterator
from random import Random

from l5x_files import add_on, alias, document, ladder, parameter, program, rung, structured, tag, task
from real_machines import MESSAGE_TAGS, drive_add_on, message_routine
from real_rungs import VARIANTS, Pools, Rungs, driven, driving
from real_types import ITEMS, Part, Values, string_type, type_text, types_of, units

PER_ROUTINE, ROUTINES = 20, 12
"""Rungs of a routine, and routines of a program: five rungs in a hundred call one."""

DRIVING = 26
"""Rungs of a program that make its inputs."""

CHAIN = 8
TAG_SHARES = {
    "BOOL": 46,
    "DINT": 24,
    "REAL": 9,
    "TIMER": 6,
    "alias": 6,
    "INT": 2,
    "COUNTER": 2,
    "STRING": 2,
    "Unit8": 1.2,
    "Unit20": 0.9,
    "Unit60": 0.6,
    "Unit150": 0.2,
    "Unit300": 0.1,
}
_UNITS = units(1_000)
_WORDS = {"WORD": "DINT", "INDEX": "DINT"}
"""Kinds of numbers with a use of their own: bits, and subscripts."""


def real_controller(rungs: int, tags: int, *, seed: int = 1, variant: str = "mix") -> str:
    """Return an export of about so many rungs and tags."""
    return Plant(rungs, tags, seed, variant).text()


class Plant:
    """One controller while it is drawn."""

    def __init__(self, rungs: int, tags: int, seed: int, variant: str) -> None:
        self._draw = Random(seed)
        self._units = units(max(20, rungs // 3))
        self._types = types_of(self._draw, max(20, rungs // 3))
        self._pools = Pools(self._draw, self._types)
        self._values = Values(self._draw, self._types)
        self._items = max(50, min(ITEMS, rungs))
        self._rungs = Rungs(self._draw, self._pools, VARIANTS[variant], self._units, self._items)
        self._kinds = {*TAG_SHARES} - {*_UNITS} | {*self._units}
        self._bits, self._text = variant == "bits", variant == "text"
        self._drives, self._messages = variant == "drives", variant == "messages"
        self._programs = max(2, round(rungs / (PER_ROUTINE * ROUTINES + DRIVING)))
        self._in_program = max(6, rungs // self._programs - DRIVING)
        self._each = max(20, tags // (self._programs + 1) - 60)

    def text(self) -> str:
        """Return the document."""
        names = [f"Area_{number}" for number in range(self._programs)]
        shared = [*self._shared(), *self._drawn("Plant", own=False)]
        programs = [self._program(name) for name in names]
        tasks = [
            task("Main", *names[1:]),
            task("Fast", names[0], kind="PERIODIC", rate=10, priority=5),
        ]
        return document(
            types=[string_type(), *self._type_texts()],
            add_ons=[] if self._bits else [*add_ons(), *([drive_add_on()] if self._drives else [])],
            tags=shared,
            programs=programs,
            tasks=tasks,
        )

    def _type_texts(self) -> Iterator[str]:
        for name, parts in self._types.items():
            yield type_text(name, parts)
        if not self._bits:
            yield type_text(
                "Cell", tuple(Part(kind, kind) for kind in ("Valve", "Scale", "Handle", "Chain8"))
            )

    # --- tags

    def _shared(self) -> Iterator[str]:
        """Yield the arrays of structures, and what copies turn into other types."""
        found = [Part(f"{kind}s", kind, self._items) for kind in ("Item", "Record")]
        for kind in self._units:
            found += [Part(f"Raw_{kind}", "DINT", 40), Part(f"Shadow_{kind}", kind)]
            found += [Part(f"{kind}_{at}", kind) for at in range(2)]
            self._pools.add(found[-2], own=False)
            self._pools.add(found[-1], own=False)
        yield from map(self._values.tag, found)

    def _drawn(self, owner: str, *, own: bool) -> Iterator[str]:
        """Yield the tags of a scope, by their shares."""
        bits: list[str] = []
        for number in range(self._each):
            kind = self._draw.choices(tuple(TAG_SHARES), tuple(TAG_SHARES.values()))[0] if number > 12 else ""
            if kind == "alias" and bits:
                name = f"{owner}_Alias_{number}"
                self._pools.alias(name, "BOOL")
                yield alias(name, self._draw.choice(bits))
                continue
            kind = kind if kind not in ("", "alias") else tuple(TAG_SHARES)[number % len(TAG_SHARES)]
            kind = "BOOL" if kind == "alias" else "Unit8" if kind not in self._kinds else kind
            part = Part(f"{owner}_{kind}_{number}", kind)
            if part.kind == "DINT" and number % 3 == 0:
                self._pools.add(part._replace(kind="WORD"), own=own)
            else:
                self._pools.add(part, own=own)
            if own and part.kind in ("BOOL", "Unit20"):
                bits.append(part.name if part.kind == "BOOL" else f"{part.name}.Value.{number % 8}")
            yield self._values.tag(part)

    # --- programs

    def _program(self, name: str) -> str:
        pools, rungs = self._pools, self._rungs
        pools.enter()
        rungs.needed = []
        tags = []
        for part in (*driven(), *(MESSAGE_TAGS if self._messages else ())):
            if part.kind == "WORD":
                pools.add(part, own=True)
            tags.append(self._values.tag(part._replace(kind=_WORDS.get(part.kind, part.kind))))
        tags += self._drawn(name, own=True)
        count = self._in_program // PER_ROUTINE or 1
        routines = [self._routine(number) for number in range(count)]
        calls = ["JSR(Drive,0);", *(self._call(number) for number in range(count))]
        tags += [self._instance(part) for part in rungs.needed]
        return program(
            name,
            ladder("Main", *calls),
            ladder("Drive", *driving(self._draw, self._items)),
            *routines,
            *([message_routine()] if self._messages else ()),
            tags=tags,
        )

    def _instance(self, part: Part) -> str:
        return tag(part.name, part.kind, str(part.length or ""))

    def _routine(self, number: int) -> str:
        """Return a routine; every twelfth, and in `text` every second one, is structured text."""
        name = f"R{number}"
        if not self._bits and (number % 2 == 0 if self._text else number % ROUTINES == 5):
            lines = self._rungs.statements(PER_ROUTINE // 3, copies=number % 4 != 2)
            return structured(name, "\n".join(lines))
        texts = list(self._rungs.routine(PER_ROUTINE))
        if self._has_parameters(number):
            texts = ["SBR(Passed_a,Passed_b)NOP();", *texts, "ADD(Passed_a,Passed_b,Passed_c)RET(Passed_c);"]
            self._rungs.needed += [Part(f"Passed_{each}", "DINT") for each in "abc" if number == 3]
        said = (
            rung(text, number=at, comment=f"rung {at} of {name}" if at % 2 else "")
            for at, text in enumerate(texts)
        )
        return ladder(name, *said)

    def _has_parameters(self, number: int) -> bool:
        return number % 4 == 3

    def _call(self, number: int) -> str:
        return (
            f"JSR(R{number},2,Tick,{number},Place);" if self._has_parameters(number) else f"JSR(R{number},0);"
        )


# --- add-ons


def add_ons() -> list[str]:
    """Return the definitions: a valve, a scaling, one that works on the caller's structures, and a chain."""
    required, bit = parameter, "BOOL"
    valve = add_on(
        "Valve",
        [required("Open", bit, "Input"), required("At", bit, "Input"), required("Coil", bit, "Output")],
        [_local("Late", "TIMER"), _local("Strokes", "DINT"), _local("Edge", bit), _local("Fault", bit)],
        ladder(
            "Logic",
            "XIC(Open)XIO(Fault)OTE(Coil);",
            "[XIC(Coil)XIO(At),XIO(Coil)XIC(At)]TON(Late,200,0);",
            "XIC(Late.DN)OTL(Fault);",
            "XIO(Open)OTU(Fault);",
            "XIC(At)ONS(Edge)LES(Strokes,100000)ADD(Strokes,1,Strokes);",
        ),
    )
    scale = add_on(
        "Scale",
        [
            required("Raw", "DINT", "Input"),
            required("Factor", "REAL", "Input"),
            required("Out", "REAL", "Output"),
        ],
        [_local("Filtered", "REAL"), _local("High", bit)],
        ladder(
            "Logic",
            "CPT(Filtered,Filtered*0.75+Raw*Factor*0.25);",
            "GRT(Filtered,100)OTE(High);",
            "MOV(Filtered,Out);",
        ),
    )
    handle = add_on(
        "Handle",
        [
            required("Unit", "Unit20", "InOut"),
            required("Thing", "Item", "InOut"),
            required("Made", "DINT", "Output"),
        ],
        [_local("Before", "Item"), _local("Text", "STRING")],
        ladder(
            "Logic",
            "COP(Thing,Before,1);",
            "LES(Thing.Count,100000)ADD(Thing.Count,1,Thing.Count);",
            "XIC(Thing.Flag0)OTE(Thing.Flag1);",
            "XIO(Before.Flag0)OTE(Thing.Flag0);",
            "COP(Thing.Name,Unit.Label,1);",
            "CONCAT('Item ',Unit.Label,Text);",
            "MOV(Thing.Count,Made);",
        ),
    )
    return [valve, scale, handle, *(_link(depth) for depth in range(1, CHAIN + 1))]


def _link(depth: int) -> str:
    """Return an add-on that calls the one below it."""
    inner = [_local("Inner", f"Chain{depth - 1}")] if depth > 1 else []
    call = f"Chain{depth - 1}(Inner,Sum,Unit,Thing,Deep);" if depth > 1 else "MOV(Sum,Deep);"
    return add_on(
        f"Chain{depth}",
        [
            parameter("Given", "DINT", "Input"),
            parameter("Unit", "Unit20", "InOut"),
            parameter("Thing", "Item", "InOut"),
            parameter("Result", "DINT", "Output"),
        ],
        [_local("Sum", "DINT"), _local("Deep", "DINT"), _local("Late", "TIMER"), *inner],
        ladder(
            "Logic",
            f"ADD(Given,{depth},Sum);",
            "XIC(Thing.Flag2)TON(Late,50,0);",
            call,
            "XIC(Late.DN)XIC(Unit.Value.3)MOV(Deep,Thing.Codes[1]);",
            "MOV(Deep,Result);",
        ),
    )


def _local(name: str, kind: str) -> str:
    return tag(name, kind).replace("Tag", "LocalTag")
