"""Random programs, what the prover says of them, and random scans that try to break what it proved."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from random import Random

from scanrack.ladder.files import parse_program
from scanrack.ladder.model.errors import LadderFault
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.claims import Claim, ClaimKind
from scanrack.ladder.prove.induction import Limits, VerdictKind, prove
from scanrack.ladder.prove.monitors import WatchedClaim, monitored

LIMITS = Limits(scans=6, k=3, fuse=32_000)
BITS, NUMBERS, REALS, TIMERS = 8, 4, 2, 3
CHANGED = 0.3
"""Share of the inputs that change before a scan."""


def program_text(rng: Random) -> str:
    """Return a random program: rungs of bits, timers, counters, numbers, jumps and one-shots."""
    rungs = [_rung(rng) for _ in range(rng.randint(3, 10))]
    if rng.random() < 0.2:
        rungs.insert(rng.randrange(len(rungs)), f"{_contact(rng)}JMP(End);")
        rungs.append("LBL(End)NOP();")
    tags = [f"TAG B{n} : BOOL" for n in range(BITS)] + [f"TAG X{n} : BOOL" for n in range(4)]
    tags += [f"TAG N{n} : {kind}" for n, kind in enumerate(("DINT", "INT", "SINT", "DINT"))]
    tags += [f"TAG R{n} : REAL" for n in range(REALS)] + ["TAG A : DINT[5]", "TAG C0 : COUNTER"]
    tags += [f"TAG T{n} : TIMER" for n in range(TIMERS)]
    tags += [f"TAG S{n} : BOOL" for n in range(4)]
    head = "PROGRAM p\nALLOW repeated coils\nALLOW repeated timers\n"
    return head + "\n".join([*tags, "ROUTINE Main", *rungs, "END", ""])


def _contact(rng: Random) -> str:
    kind = rng.randrange(10)
    if kind < 6:
        name = rng.choice([f"B{rng.randrange(BITS)}", f"X{rng.randrange(4)}"])
        return f"{rng.choice(('XIC', 'XIO'))}({name})"
    if kind == 6:
        return f"XIC(T{rng.randrange(TIMERS)}.{rng.choice(('DN', 'TT', 'EN'))})"
    if kind == 7:
        return f"{rng.choice(('EQU', 'GRT', 'LES', 'GEQ', 'NEQ'))}({_number(rng)},{rng.randint(-2, 6)})"
    if kind == 8:
        return rng.choice(
            (f"LIM(1,{_number(rng)},5)", "XIC(C0.DN)", "XIC(N0.3)", f"GRT(R{rng.randrange(REALS)},2.5)")
        )
    return f"ONS(S{rng.randrange(4)})"


def _number(rng: Random) -> str:
    return rng.choice((*[f"N{n}" for n in range(NUMBERS)], "A[2]", "A[N3]", "T0.ACC", "C0.ACC"))


def _rung(rng: Random) -> str:
    before = "".join(_contact(rng) for _ in range(rng.randint(1, 3)))
    if rng.random() < 0.3:
        before += f"[{_contact(rng)},{_contact(rng)}{_contact(rng)}]"
    return before + _output(rng) + ";"


def _output(rng: Random) -> str:
    bit, number = f"B{rng.randrange(BITS)}", f"N{rng.randrange(NUMBERS)}"
    kind = rng.randrange(12)
    if kind < 6:
        return f"{rng.choice(('OTE', 'OTE', 'OTL', 'OTU'))}({bit})"
    if kind < 8:
        return rng.choice(("TON(T0,30,0)", "TOF(T1,50,0)", "RTO(T2,80,0)", "RES(T2)"))
    if kind == 8:
        return rng.choice(("CTU(C0,3,0)", "CTD(C0,3,0)", "RES(C0)"))
    return rng.choice(
        (
            f"ADD({number},1,{number})",
            f"MOV({rng.randint(-1, 5)},{number})",
            f"SUB({_number(rng)},{number},{number})",
            "CPT(N1,N0*3-A[1])",
            f"MOV(R{rng.randrange(REALS)},{number})",
            f"MUL({_number(rng)},0.5,R0)",
            "MOV(N0,A[N3])",
            "FLL(N1,A[0],3)",
            "BTD(N0,1,N3,0,2)",
        )
    )


SHAPES = (
    "{a} AND {b}",
    "{a} AND NOT {b}",
    "NOT {a} AND NOT {b}",
    "N0 > {n}",
    "{a} AND N1 < {n}",
    "T0.DN AND {a}",
)


def claims(rng: Random) -> list[Claim]:
    """Return random conditions that are never to hold."""
    found = []
    for number in range(4):
        bits = [f"B{rng.randrange(BITS)}" for _ in "ab"]
        text = rng.choice(SHAPES).format(a=bits[0], b=bits[1], n=rng.randint(-1, 6))
        found.append(Claim(f"{number}", ClaimKind.NEVER, text))
    return found


@dataclass
class Proofs:
    """What was found so far."""

    count: Counter[str] = field(default_factory=Counter)
    broken: list[str] = field(default_factory=list)

    def try_one(self, seed: int, runs: int = 4, scans: int = 150) -> None:
        """Ask of one random program; run what is proved; note what is wrong."""
        rng = Random(seed)
        checked = monitored(parse_program(program_text(rng)), claims(rng))
        bounds = rng.choice((ScanBounds(1, 100), ScanBounds(1, 1000), ScanBounds(10, 10)))
        problem = ProgramSystem(checked.program, bounds)
        self.count["programs"] += 1
        proved = []
        for watched in checked.properties:
            verdict = prove(problem, watched.bit, LIMITS)
            self.count[verdict.kind] += 1
            self.count["proved with k > 0"] += verdict.kind is VerdictKind.PROVED and verdict.k > 0
            self.count["by havoc"] += any("not modeled" in each for each in verdict.blame)
            self.broken += [f"{seed}: {each}" for each in verdict.blame if "differ" in each]
            if verdict.kind is VerdictKind.PROVED:
                proved.append(watched)
        for _ in range(runs if proved else 0):
            self._run(problem, proved, rng, seed, scans)

    def _run(
        self, problem: ProgramSystem, proved: list[WatchedClaim], rng: Random, seed: int, scans: int
    ) -> None:
        engine = problem.program.compile()
        inputs = [
            (problem.leaf(key), key[1])
            for name, key in problem.key_of.items()
            if problem.role(name) == "free"
        ]
        low, high = problem.bounds.low_ms, problem.bounds.high_ms
        for number in range(scans):
            for leaf, index in inputs:
                if rng.random() < CHANGED:
                    engine.memory.write(
                        leaf, index, rng.random() < 0.5 if leaf.type.is_bool else rng.randint(0, 5)
                    )
            try:
                engine.step(max(low, min(high, rng.choice((1, 5, 50, 100, 1000)))))
            except LadderFault:
                self.count["runs that fault"] += 1
                return
            self.count["scans"] += 1
            for watched in proved:
                if not watched.holds(engine):
                    self.broken.append(f"{seed}: {watched.claim.text} in scan {number}")
                    return
