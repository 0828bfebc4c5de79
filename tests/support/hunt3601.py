"""How soon random scripts find a broken module: what the test and the benchmark of the proof share."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from broken3601 import Mistake
from hypothesis import HealthCheck, Phase, given, settings
from lockstep3601 import GivenUp, Lockstep
from stories3601 import scripts

CI_EXAMPLES = 60
"""Scripts per theme that the CI profile plays against the oracle."""


class Hunt(NamedTuple):
    """What became of the search for one mistake.

    Attributes:
        mistake: the mistake.
        examples: number of the first script that shows it; None if none does.
        symptom: first line of what was seen.
        tried: number of scripts played.
    """

    mistake: Mistake
    examples: int | None
    symptom: str
    tried: int


@cache
def scripts_of(theme: str, examples: int = CI_EXAMPLES) -> tuple:
    """Return the scripts of a theme that the CI profile plays, in its order as far as none of them fails."""
    made = []

    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(scripts(theme))
    def collect(script):
        made.append(script)

    collect()
    return tuple(made)


def symptom(script) -> str:
    """Play a script on module and oracle; return the first line of what differs, or ""."""
    setting, steps = script
    try:
        bench = Lockstep(setting)
        for step in steps:
            step.play(bench)
    except GivenUp:
        return ""
    except Exception as error:  # a module that raises is broken, too
        return str(error).partition("\n")[0] or type(error).__name__
    return ""


def hunt(mistake: Mistake, examples: int = CI_EXAMPLES) -> Hunt:
    """Play the scripts of the mistake's theme until one shows it."""
    made = scripts_of(mistake.theme, examples)
    with mistake.made():
        for number, script in enumerate(made, start=1):
            seen = symptom(script)
            if seen:
                return Hunt(mistake, number, seen, number)
    return Hunt(mistake, None, "", len(made))
