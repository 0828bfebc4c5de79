"""Rungs and statements in the proportions of real ones, for `real_mix`.

What is written stays in bounds in any number of scans: numbers that are added up are guarded, indexes count
in a range, texts are built from constants, and what a copy makes of other bytes goes to tags of its own.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from random import Random

from real_machines import SPECIALS
from real_types import BEHIND, Part, Types, places

SHARES: Mapping[str, float] = {
    "add_on": 4.9,
    "copy": 4.1,
    "subscript": 4.0,
    "string": 3.6,
    "timer": 6.3,
    "status": 1.0,
    "jump": 2.2,
    "plain": 73.9,
}
"""Rungs of each kind in a hundred of real machines."""

VARIANTS: dict[str, dict[str, float]] = {
    "bits": {"bits": 100},
    "mix": dict(SHARES),
    "structures": {**SHARES, "copy": 30, "plain": 48},
    "strings": {**SHARES, "string": 30, "plain": 47.5},
    "add_ons": {**SHARES, "add_on": 30, "plain": 48.8},
    "arrays": {**SHARES, "subscript": 40, "plain": 37.9},
    "text": dict(SHARES),
    "drives": {**SHARES, "drive": 12, "plain": 61.9},
    "messages": {**SHARES, "call": 12, "string": 12, "plain": 53.5},
    "alarms": {**SHARES, "alarm": 12, "queue": 8, "plain": 53.9},
}
"""Shares of rungs in programs that use one thing more; `text` has structured text beside its rungs."""

OTHERS = 1.2
"""Special rungs are drawn so much more often: rungs that drive a program or call routines are plain."""

_FILLING = ("plain", "bits")

DEPTHS = {0: 44.0, 1: 46.0, 2: 10.0}
"""Depths of the plain rungs, so that of all rungs 65.9 % have none, 27.7 % one, 5.4 % two."""

WORD_BITS = 0.13
"""Share of contacts and coils that are bits of a word: a third of the rungs then have one."""

_CONTACTS = {
    "XIC": 11_104,
    "XIO": 3_908,
    "EQU": 2_385,
    "ONS": 586,
    "GRT": 451,
    "GEQ": 259,
    "LES": 248,
    "LEQ": 243,
    "LIM": 187,
    "NEQ": 173,
    "CMP": 137,
}
_COILS = {"OTE": 3_843, "OTU": 1_816, "OTL": 828}
_OUTPUTS = {
    **_COILS,
    "MOV": 3_098,
    "CPT": 656,
    "ADD": 379,
    "NOP": 289,
    "SUB": 196,
    "MUL": 192,
    "RES": 123,
    "CLR": 112,
    "FLL": 98,
    "DIV": 63,
    "CTU": 54,
}
SCRATCH = ("Text_a", "Text_b", "Text_c")
"""Texts that rungs build; nothing is built from what another rung left there."""

INPUTS, NOISES, INDEXES = 16, 4, 4


class Pools:
    """Names of tags and members by kind; half of those drawn are the program's own."""

    def __init__(self, draw: Random, types: Types) -> None:
        self._draw, self._types = draw, types
        self._shared: dict[str, list[str]] = defaultdict(list)
        self._own: dict[str, list[str]] = defaultdict(list)

    def enter(self) -> None:
        """Start the tags of another program."""
        self._own.clear()

    def add(self, part: Part, *, own: bool) -> None:
        """Add a tag, and some of its members."""
        pool = self._own if own else self._shared
        found = list(places(self._types, part))
        few = found if len(found) <= 12 else [found[0], *self._draw.sample(found[1:], 12)]
        for path, kind in few:
            pool[kind].append(path)

    def alias(self, name: str, kind: str) -> None:
        """Add another name of a bit or a number."""
        self._own[kind].append(name)

    def pick(self, kind: str) -> str:
        """Draw a name."""
        own, shared = self._own[kind], self._shared[kind]
        return self._draw.choice(own if own and (not shared or self._draw.random() < 0.5) else shared)


class Rungs:
    """Draws the rungs of a controller; collects the tags that they need one each of."""

    def __init__(
        self, draw: Random, pools: Pools, shares: Mapping[str, float], units: Sequence[str], items: int
    ) -> None:
        self._draw, self._pools, self._units, self._items = draw, pools, units, items
        self._shares = {kind: share * (1 if kind in _FILLING else OTHERS) for kind, share in shares.items()}
        self._calls = self._edges = 0
        self.needed: list[Part] = []
        """Tags of the program that its rungs need: instances and storage bits."""

    def _weighed(self, shares: Mapping[str, float]) -> str:
        return self._draw.choices(tuple(shares), tuple(shares.values()))[0]

    def routine(self, count: int) -> Iterator[str]:
        """Yield so many rungs."""
        waiting = ""
        for number in range(count):
            kind = self._weighed(self._shares)
            if waiting and number % 3 == 0:
                yield f"LBL({waiting})NOP();"
                waiting = ""
            elif kind == "jump" and not waiting and number < count - 4:
                waiting = f"L{number}"
                yield f"{self._contact()}JMP({waiting});"
            else:
                yield f"{self._rung('plain' if kind == 'jump' else kind)};"
        if waiting:
            yield f"LBL({waiting})NOP();"

    def _rung(self, kind: str) -> str:
        if kind in ("plain", "bits"):
            return self._plain(_COILS if kind == "bits" else _OUTPUTS)
        made = {
            "add_on": self._add_on,
            "copy": self._copy,
            "subscript": self._subscript,
            "string": self._string,
            "timer": self._timer,
            "status": self._status,
        }.get(kind) or partial(SPECIALS[kind], self._draw, self._pools.pick, self._need)
        return f"{self._input()}{made()}"

    def _need(self, kind: str, length: int) -> str:
        """Return the name of a new tag of the program."""
        name = f"{kind.title().replace('_', '')}_{len(self.needed)}"
        self.needed.append(Part(name, kind, length))
        return name

    # --- conditions

    def bit(self) -> str:
        """Return a bit to read."""
        chance = self._draw.random()
        if chance < WORD_BITS:
            return f"{self._pools.pick('WORD')}.{self._draw.randrange(16)}"
        if chance < 0.2:
            return f"{self._pools.pick('TIMER')}.{self._draw.choice(('DN', 'TT', 'EN'))}"
        return self._input_bit() if chance < 0.5 else self._pools.pick("BOOL")

    def _input_bit(self) -> str:
        return f"In_{self._draw.randrange(INPUTS)}"

    def _input(self) -> str:
        """Return a condition that is often true."""
        return f"{self._draw.choice(('XIC', 'XIO'))}({self._input_bit()})" * self._draw.randrange(1, 3)

    def _coil(self) -> str:
        if self._draw.random() < WORD_BITS:
            return f"Word_{self._draw.randrange(NOISES)}.{self._draw.randrange(16)}"
        return self._pools.pick("BOOL")

    def _contact(self, *, bits: bool = False) -> str:
        name = self._weighed({"XIC": 3, "XIO": 1} if bits else _CONTACTS)
        number = self._pools.pick
        if name in ("XIC", "XIO"):
            return f"{name}({self.bit()})"
        if name == "ONS":
            return f"XIC({self.bit()})ONS({self._edge()})"
        if name == "LIM":
            return f"LIM(5,{number('DINT')},{self._draw.randrange(20, 90)})"
        if name == "CMP":
            return f"CMP({number('DINT')}*2>{number('DINT')}+{self._draw.randrange(9)})"
        kind = "REAL" if name not in ("EQU", "NEQ") and self._draw.random() < 0.2 else "DINT"
        other = number(kind) if self._draw.random() < 0.2 else self._draw.randrange(100)
        return f"{name}({number(kind)},{other})"

    def _edge(self) -> str:
        name = f"Edge_{self._edges}"
        self._edges += 1
        self.needed.append(Part(name, "BOOL"))
        return name

    def _series(self, depth: int, *, bits: bool) -> str:
        found = "".join(self._contact(bits=bits) for _ in range(self._draw.randrange(1, 4)))
        if depth:
            legs = (self._series(at, bits=bits) for at in (depth - 1, *[0] * self._draw.randrange(1, 3)))
            found += f"[{','.join(legs)}]"
        return found

    def _plain(self, outputs: Mapping[str, float]) -> str:
        depth = int(self._weighed({str(key): share for key, share in DEPTHS.items()}))
        bits = outputs is _COILS
        acts = [self._output(self._weighed(outputs)) for _ in range(self._draw.choice((1, 1, 1, 2)))]
        if depth and len(acts) > 1:
            return f"{self._series(0, bits=bits)}[{','.join(acts)}]"
        return self._series(depth, bits=bits) + "".join(acts)

    # --- outputs

    def _output(self, name: str) -> str:
        draw, pick = self._draw, self._pools.pick
        if name in _COILS:
            return f"{name}({self._coil()})"
        if name == "CPT":
            return self._computed()
        if name == "ADD":
            goal = pick("DINT")
            return f"LES({goal},100000)ADD({goal},{draw.randrange(1, 9)},{goal})"
        if name == "SUB":
            goal = pick("DINT")
            return f"GRT({goal},-100000)SUB({goal},{draw.randrange(1, 9)},{goal})"
        if name in ("MUL", "DIV"):
            return f"{name}(Ix_{draw.randrange(INDEXES)},{draw.randrange(2, 9)},{pick('DINT')})"
        if name == "MOV":
            kind = "REAL" if draw.random() < 0.15 else "DINT"
            source = draw.randrange(100) if draw.random() < 0.6 else pick(kind)
            return f"MOV({source},{pick(kind)})"
        if name == "RES":
            return f"RES({pick(draw.choice(('TIMER', 'COUNTER')))})"
        if name == "FLL":
            return f"FLL({draw.randrange(2)},Table_{draw.randrange(4)}[0],{draw.randrange(5, 20)})"
        if name == "CTU":
            return f"CTU({pick('COUNTER')},?,?)"
        return "NOP()" if name == "NOP" else f"CLR({pick('DINT')})"

    def _computed(self) -> str:
        number, draw = self._pools.pick, self._draw
        if draw.random() < 0.4:
            return f"CPT({number('REAL')},{number('REAL')}*0.75+Ix_{draw.randrange(INDEXES)}*0.125-1.5)"
        return f"CPT({number('DINT')},(Ix_{draw.randrange(INDEXES)}*3+{number('INT')})/2 MOD 1000)"

    def _timer(self) -> str:
        return f"TON({self._pools.pick('TIMER')},?,?)"

    def _status(self) -> str:
        if self._draw.random() < 0.7:
            return "GSV(WallClockTime,,LocalDateTime,Clock[0])"
        return "GSV(Task,Fast,OverlapCount,Overlaps)"

    def _subscript(self) -> str:
        draw, pick = self._draw, self._pools.pick
        item = f"Items[{self._index()}]"
        record = f"Records[{self._index()}]"
        return draw.choice(
            (
                f"MOV({item}.Count,{pick('DINT')})",
                f"MOV(Ix_{draw.randrange(INDEXES)},{item}.Codes[Jx])",
                f"XIC({item}.Flag{draw.randrange(6)})OTE({self._coil()})",
                f"[XIC({record}.Flag0),XIC({self.bit()})]OTE({record}.Flag1)",
                f"LES({record}.Count,100000)ADD({record}.Count,1,{record}.Count)",
                f"CPT({record}.Weight,{item}.Weight*0.5+1.5)",
                f"GRT(Table_{draw.randrange(4)}[Jx],5)MOV(Table_{draw.randrange(4)}[Jx+1],{pick('DINT')})",
                f"TON({record}.Late,?,?)",
            )
        )

    def _index(self) -> str:
        return f"Ix_{self._draw.randrange(INDEXES)}" + self._draw.choice(("", "", "+3"))

    def _copy(self) -> str:
        """Return a copy: of a structure, of elements, of strings, or of other types as bytes."""
        draw, pick = self._draw, self._pools.pick
        name = draw.choice(("COP", "COP", "COP", "COP", "CPS"))
        kind = draw.choice(self._units)
        index, other, table = self._index(), self._index(), draw.randrange(4)
        return draw.choice(
            (
                f"{name}({pick(kind)},{pick(kind)},1)",
                f"{name}({pick(kind)},Shadow_{kind},1)",
                f"{name}(Items[{index}],Items[{other}],{draw.randrange(1, 9)})",
                f"{name}(Records[{index}],Records[{other}],1)",
                f"{name}({pick('Name20')},{pick('Name20')},1)",
                f"{name}({pick(kind)},Raw_{kind}[0],{draw.randrange(2, 6)})",
                f"{name}(Raw_{kind}[0],Shadow_{kind},1)",
                f"{name}(Table_{table}[0],Table_{(table + 1) % 4}[3],{draw.randrange(2, 16)})",
                f"{name}(Text_a.DATA[0],Bytes[0],{draw.randrange(4, 20)})",
                f"{name}(Raw_{kind}[0],Bytes[8],{draw.randrange(4, 20)})",
                f"FLL(0,Items[{index}],{draw.randrange(1, 9)})",
            )
        )

    def _string(self) -> str:
        """Return a text built step by step, as messages to people and labels are."""
        draw, pick = self._draw, self._pools.pick
        a, b, c = SCRATCH
        start = f"DTOS(Ix_{draw.randrange(INDEXES)},{a})CONCAT('Part ',{a},{b})"
        return start + draw.choice(
            (
                f"CONCAT({b},{pick('Name20')},{c})",
                f"MID({b},3,2,{c})",
                f"INSERT({b},'no. ',6,{c})",
                f"DELETE({b},2,1,{c})",
                f"FIND({b},'t',1,Place)",
                f"UPPER({b},{c})",
                f"RTOS({pick('REAL')},{c})CONCAT({b},' kg',{a})",
                f"STOD({a},Place)",
                f"EQU({c},{b})COP({b},{pick('STRING')},1)",
                f"CONCAT({b},'$N',{c})CONCAT({c},{pick('Name20')},{a})",
            )
        )

    # --- add-ons

    def _add_on(self) -> str:
        """Return a call with an instance of its own: a tag, an element of an array, a member."""
        draw, pick = self._draw, self._pools.pick
        kind = self._weighed({"Valve": 4, "Scale": 3, "Handle": 2, "Chain8": 1})
        place = self._instance(kind)
        index = self._index() if draw.random() < 0.5 else draw.randrange(self._items)
        item = f"Items[{index}]"
        return {
            "Valve": lambda: f"Valve({place},{self.bit()},{self.bit()},{self._coil()})",
            "Scale": lambda: f"Scale({place},{pick('DINT')},0.5,{pick('REAL')})",
            "Handle": lambda: f"Handle({place},{pick('Unit20')},{item},{pick('DINT')})",
            "Chain8": lambda: f"Chain8({place},Ix_{draw.randrange(INDEXES)},{pick('Unit20')},{item},Place)",
        }[kind]()

    def _instance(self, kind: str) -> str:
        number, self._calls = self._calls, self._calls + 1
        if number % 5 == 4:
            self.needed.append(Part(f"{kind}s_{number}", kind, 4))
            return f"{kind}s_{number}[{number % 4}]"
        if number % 10 == 5:
            self.needed.append(Part(f"Cell_{number}", "Cell"))
            return f"Cell_{number}.{kind}"
        self.needed.append(Part(f"{kind}_{number}", kind))
        return f"{kind}_{number}"

    # --- structured text

    def statements(self, count: int, *, copies: bool) -> Iterator[str]:
        """Yield lines of structured text, with copies and strings if wanted."""
        draw, pick = self._draw, self._pools.pick
        a, b, c = SCRATCH
        for _ in range(count):
            number, real = pick("DINT"), pick("REAL")
            kind = draw.choice(self._units)
            building = [f"IF {self._input_bit()} THEN", f"DTOS(Ix_0, {a});", f"CONCAT('Part ', {a}, {b});"]
            building += [f"CONCAT({b}, {pick('Name20')}, {c});", "END_IF;"]
            moving = [f"IF {self.bit()} THEN", f"COP({pick(kind)}, {pick(kind)}, 1);", "END_IF;"]
            blocks = [
                [f"{real} := {real} * 0.5 + 1.25;", f"{pick('BOOL')} := {self.bit()} AND NOT {self.bit()};"],
                [
                    f"IF {self.bit()} AND {number} < 90 THEN",
                    f"{number} := {number} + 1;",
                    f"ELSIF {self.bit()} THEN",
                    f"{number} := 0;",
                    "END_IF;",
                ],
                [
                    f"CASE {number} OF",
                    f"0..9: {pick('DINT')} := 1;",
                    "10, 20: Place := 2;",
                    "ELSE Place := 3;",
                    "END_CASE;",
                ],
                ["FOR Loop := 0 TO 4 DO", f"Table_{draw.randrange(4)}[Loop] := Loop * 2 + Jx;", "END_FOR;"],
                [f"Items[{self._index()}].Count := Ix_1;"],
            ]
            yield from draw.choice([*blocks, building, moving, building] if copies else blocks)


def driving(draw: Random, items: int) -> Iterator[str]:
    """Yield the rungs that change what a program's other rungs look at."""
    yield "ADD(Tick,1,Tick)GRT(Tick,30000)CLR(Tick);"
    for number in range(NOISES):
        yield f"MUL(Tick,{draw.randrange(3, 997, 2)},Noise_{number});"
    for number in range(INPUTS):
        yield f"XIC(Noise_{number % NOISES}.{draw.randrange(1, 12)})OTE(In_{number});"
    for number in range(INDEXES):
        yield f"ADD(Ix_{number},{number + 1},Ix_{number})GRT(Ix_{number},{items - BEHIND})CLR(Ix_{number});"
    yield "ADD(Jx,1,Jx)GRT(Jx,3)CLR(Jx);"


def driven() -> list[Part]:
    """Return the tags of a program that `driving` and the rungs use by name."""
    return [
        Part("Tick", "DINT"),
        *(Part(f"Noise_{number}", "WORD") for number in range(NOISES)),
        *(Part(f"Word_{number}", "WORD") for number in range(NOISES)),
        *(Part(f"In_{number}", "BOOL") for number in range(INPUTS)),
        *(Part(f"Ix_{number}", "INDEX") for number in range(INDEXES)),
        Part("Jx", "INDEX"),
        Part("Loop", "INDEX"),
        Part("Place", "INDEX"),
        Part("Overlaps", "INDEX"),
        Part("Clock", "DINT", 7),
        Part("Bytes", "SINT", 100),
        *(Part(f"Table_{number}", "DINT", 20) for number in range(4)),
        *(Part(each, "STRING") for each in SCRATCH),
    ]
