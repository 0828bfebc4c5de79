"""Dice: bytes that scripts are chosen by, all of a script's in a single draw.

    recipe = any_of(pick(Wait, [1, 20]), pick(Input, [HOME, ESTOP], [True], [0, 5]))
    step = recipe(Dice(bytes([255, 0, 0, 255]), draw))      # Input(HOME, True, 5)

A recipe is a function of dice. Drawing each value by a strategy of its own takes several times as long
as playing the script; and Hypothesis tries copies of what it has drawn in other places of the same kind
before it draws anew, so that five scripts of six were hardly new ones.

A byte of 0 means the first value of a list, which is the plainest. So a failing script shrinks toward
plain values, and toward fewer stories where a story begins with `told`.
"""

from __future__ import annotations

from hypothesis import strategies as st

BYTES = 60
"""More than any story needs."""


class Dice:
    """Chooses by one byte after the other; when they are used up, the first of everything.

    Args:
        thrown: the bytes.
        draw: Hypothesis's, for what is drawn by a strategy.
    """

    def __init__(self, thrown, draw):
        self.left = iter(thrown)
        self.draw = draw

    def one_of(self, values):
        """One of up to 256 values."""
        return values[len(values) * next(self.left, 0) // 256]


def pick(make, *lists):
    """A recipe of what `make` makes of one value of each list."""
    return lambda dice: make(*[dice.one_of(each) for each in lists])


def any_of(*recipes):
    """A recipe that is one of these, recipes or plain values."""
    return lambda dice: made(dice.one_of(recipes), dice)


def drawn(strategy, make):
    """A recipe of what `make` makes of a value that a strategy draws."""
    return lambda dice: make(dice.draw(strategy))


def story(*parts):
    """A recipe of parts one after the other; a part is a step, a list of steps, or a recipe of either."""

    def steps_of(dice):
        return [step for part in parts for step in listed(made(part, dice))]

    return steps_of


def made(part, dice):
    return part(dice) if callable(part) else part


def listed(part):
    return part if isinstance(part, list) else [part]


@st.composite
def strategy(draw, recipe):
    """A recipe as a strategy of its own, for where Hypothesis shall try its copies in other places."""
    return recipe(Dice(draw(st.binary(min_size=BYTES, max_size=BYTES)), draw))
