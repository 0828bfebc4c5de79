"""Small ladder programs on both back ends."""

from scanrack.ladder import REPEATED_COILS
from scanrack.ladder.files import parse_program


class Named:
    """An engine that shows which one it is as a test's id."""

    def __init__(self, name, engine):
        self.__dict__.update(name=name, engine=engine)

    def __str__(self):
        return self.name

    def __getattr__(self, name):
        return getattr(self.engine, name)


def program_of(tags, *rungs, sub=None):
    """Return a program of one routine, and a subroutine Sub if its rungs are given."""
    text = [f"PROGRAM bench\nALLOW {REPEATED_COILS}", tags, "ROUTINE Main", *rungs, "END"]
    if sub is not None:
        text += ["ROUTINE Sub", sub, "END"]
    return parse_program("\n".join(text) + "\n")


def both(tags, *rungs, sub=None):
    """Return an engine of either kind for a small program."""
    program = program_of(tags, *rungs, sub=sub)
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]
