"""Plans: scenes of words and waits in a TOML file.

    name = "an hour"
    rpi_ms = 2
    begin = '''
    zero                                                                 for 100 ms
    words 843Ch 3Ch 0 500                                                for 150 ms
    zero                                                                 for 100 ms
    '''

    [[scene]]
    name = "relative move"
    why = "the profile of a move, Move Complete at its end"
    settles = ["A-35"]
    steps = '''
    RELATIVE_MOVE target 3000 speed 2500 acceleration 5 deceleration 5   until MOVE_COMPLETE
    idle                                                                 for 100 ms
    '''

Each scene begins with the steps of `begin`, unless the scene has its own `begin`. Lines have the syntax of a
`.steps` file. In addition, `inputs ESTOP HOME for 100 ms` energizes wired inputs.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.doors import toml_tables
from scanrack.io_images.image import Image
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind, TextLimitError
from scanrack.io_images.times import exact_ns
from scanrack.ladder.files.steps import Step, StepsError, parse_steps

from .moments import Timing

BUILT_IN = ("hour", "quick")
"""Plans that come with scanrack."""

NEEDS = ("inputs", "encoder")
"""Additional equipment that a scene may need: inputs that are wired to outputs, or an encoder."""

_INPUTS = {str(bit.name): bit.value for bit in InputBit}


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _SceneTable(_Table):
    name: Annotated[str, Field(min_length=1, max_length=80)]
    steps: Annotated[str, Field(max_length=100_000)]
    begin: str | None = None
    why: str = ""
    settles: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()


class _PlanTable(_Table):
    name: str = "plan"
    rpi_ms: Annotated[float, Field(gt=0, le=1000)] = 2
    scan_ms: Annotated[float, Field(gt=0, le=1000)] = 10
    drift_ppm: Annotated[int, Field(ge=0, le=10_000)] = 100
    begin: str = ""
    limit_s: Annotated[float, Field(gt=0, le=600)] = 30
    firmware: str = "4.1"
    scene: tuple[_SceneTable, ...]


@dataclass(frozen=True, slots=True)
class SceneStep:
    """Words or inputs, and the time that they stay in effect.

    Attributes:
        step: the step with the words; None for inputs.
        inputs: mask of the energized inputs.
        for_ns: time for which the inputs stay in effect, ns.
    """

    step: Step | None
    inputs: int = 0
    for_ns: int = 0

    def over(self, image: Image, lasted_ns: int) -> bool:
        """Whether the step is over. `lasted_ns` is the time since the step began, ns."""
        return lasted_ns >= self.for_ns if self.step is None else self.step.ends(image, lasted_ns)


@dataclass(frozen=True, slots=True)
class PlannedScene:
    """A scene of a plan.

    Attributes:
        why: the purpose of the scene.
        settles: readings that it settles, such as "A-35".
        needs: names from `NEEDS`.
    """

    name: str
    steps: tuple[SceneStep, ...]
    why: str = ""
    settles: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ScenePlan:
    """A plan.

    Attributes:
        limit_ns: longest time of a step that waits for bits, ns.
        firmware: firmware of the module.
    """

    name: str
    scenes: tuple[PlannedScene, ...]
    timing: Timing
    limit_ns: int
    firmware: str


def load_plan(name: str) -> ScenePlan:
    """Load a plan: one of `BUILT_IN`, or a file.

    Raises:
        ValueError: the file can't be read, or a key or step is invalid.
    """
    if name in BUILT_IN:
        text = (files(__package__) / f"{name}.toml").read_text("utf-8")
    else:
        try:
            text = read_input_text(Path(name), TextKind.PLAN)
        except OSError as error:
            raise ValueError(
                f"{name}: {error.strerror}; built in for a 3601 are {', '.join(BUILT_IN)}"
            ) from error
        except UnicodeDecodeError as error:
            raise ValueError(f"{name}: it is not text in UTF-8: {error.reason}") from None
    return parse_plan(text, name)


def parse_plan(text: str, name: str) -> ScenePlan:
    """Return the plan in a TOML text.

    Raises:
        ValueError: see `load_plan`.
    """
    try:
        table = _PlanTable.model_validate(toml_tables(text, TextKind.PLAN))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise ValueError(f"{name}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    except TextLimitError as error:
        raise ValueError(f"{name}:{error.line}: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{name}: {error}") from None
    scenes = tuple(_scene(scene_table, table.begin, name) for scene_table in table.scene)
    for scene_name, count in Counter(scene.name for scene in scenes).items():
        if count > 1:
            raise ValueError(f"{name}: duplicate scene {scene_name!r}")
    try:
        rpi_ns, scan_ns = exact_ns(table.rpi_ms, "ms", "rpi_ms"), exact_ns(table.scan_ms, "ms", "scan_ms")
        limit_ns = exact_ns(table.limit_s, "s", "limit_s")
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    timing = Timing(rpi_ns, scan_ns, drift_ppm=table.drift_ppm)
    return ScenePlan(table.name, scenes, timing, limit_ns, table.firmware)


def _scene(table: _SceneTable, begin: str, file: str) -> PlannedScene:
    """Return a table's scene; raise ValueError for an unknown need, wrong step, or no configuration."""
    place = f"{file}: scene {table.name!r}"
    for need in table.needs:
        if need not in NEEDS:
            raise ValueError(f"{place} needs {need!r}; choose from {', '.join(NEEDS)}")
    steps = tuple(_steps(begin if table.begin is None else table.begin, place) + _steps(table.steps, place))
    if not _is_configured(steps):
        raise ValueError(f"{place}: the first words must be zero, and the second a configuration")
    return PlannedScene(table.name, steps, table.why, table.settles, table.needs)


def _steps(text: str, place: str) -> list[SceneStep]:
    """Parse the steps in a text; the message of a ValueError begins with `place`."""
    steps = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            steps.append(_step(words))
        except StepsError as error:
            raise ValueError(f"{place}, line {number}: {error.reason}") from None
        except ValueError as error:
            raise ValueError(f"{place}, line {number}: {error}") from None
    return steps


def _step(words: list[str]) -> SceneStep:
    """Parse a step. The step parser also reads the duration of `inputs`."""
    if words[0] != "inputs":
        step = parse_steps(" ".join(words)).steps[0]
        if step.for_ns is None and not step.rise and not step.fall:
            raise ValueError(f"{' '.join(words)!r} has no end; add for N ms, or until and bits")
        return SceneStep(step)
    end = words.index("for") if "for" in words else len(words)
    step = parse_steps(" ".join(["same", *words[end:]])).steps[0]
    names = set(words[1:end])
    if names - _INPUTS.keys() or step.for_ns is None:
        raise ValueError(f"invalid step {' '.join(words)!r}; must be inputs {' '.join(_INPUTS)} for N ms")
    return SceneStep(None, sum(_INPUTS[name] for name in names), step.for_ns)


def _is_configured(steps: tuple[SceneStep, ...]) -> bool:
    """Whether the first words are zero and the second words are a configuration."""
    images = []
    for step in steps[:2]:
        image = Image([1] * 8)
        if step.step is not None:
            step.step.write(image)
        images.append(tuple(image))
    return len(images) == 2 and not any(images[0]) and images[1][0] < 0
