"""Small programs of RSLogix 500 on both back ends."""

from scanrack.ladder import LadderFault
from scanrack.rockwell.slc import import_text

SLOTS = "SLOT 1 OTHER 3 10 25\n"


def imported(*rungs, data=(), sub=(), slots=None):
    """Return what became of rungs of the main file, and of a subroutine file 3."""
    lines = [SLOTS, 'LADDER 2 "MAIN"', *(f"SOR {each} EOR" for each in rungs)]
    if sub:
        lines += ["LADDER 3", *(f"SOR {each} EOR" for each in sub)]
    lines += [f"DATA {each}" for each in data]
    return import_text("\n".join(lines), "bench", slots=slots)


class Bench:
    """Both back ends of a program, which must agree after each scan."""

    def __init__(self, *rungs, data=(), sub=()):
        found = imported(*rungs, data=data, sub=sub)
        assert not found.report.refused, list(map(str, found.report.refused))
        self.program = found.program
        self.engines = [self.program.compile(), self.program.interpret()]

    def __getitem__(self, name):
        return self.engines[0].tags[name]

    def __setitem__(self, name, value):
        for engine in self.engines:
            engine.tags[name] = value

    def scan(self, scans=1, ms=10):
        """Do scans; return the fault that both stop at, None without one."""
        faults: list[LadderFault | None] = []
        for engine in self.engines:
            try:
                for _ in range(scans):
                    engine.step(ms)
                faults.append(None)
            except LadderFault as fault:
                faults.append(fault)
        assert str(faults[0]) == str(faults[1])
        first, second = (engine.memory.snapshot() for engine in self.engines)
        assert first == second
        return faults[0]


def after(*rungs, data=(), scans=1, sub=()):
    """Return a bench after scans that brought no fault."""
    bench = Bench(*rungs, data=data, sub=sub)
    assert bench.scan(scans) is None
    return bench
