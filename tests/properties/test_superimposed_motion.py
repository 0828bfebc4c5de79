"""Superimposed motion is the sum of its parts alone, whatever begins, changes and stops them, and when.

One axis has it all; three others have the jog, the moves and the gear alone. Both back ends keep step. What
merges goes on from the speed of the axis, so no speed ever jumps.
"""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ladder_bench import both

ALONE = {"Jog": "Jogs", "Move": "Moves", "Gear": "Gears"}
"""Motion types of MAS and MCD, and the axis that has it alone."""

STATUS = {"Jog": "JogStatus", "Move": "MoveStatus", "Gear": "GearingStatus"}

numbers = st.integers(1, 40).map(lambda each: each / 8)
curves = st.sampled_from(("Trapezoidal,100,100", "S-Curve,100,60"))
MERGE = "Disabled,Programmed"


@st.composite
def profiles(draw):
    up, down = draw(numbers), draw(numbers)
    speed = f"{draw(numbers)},Units per sec,{up},Units per sec2,{down},Units per sec2"
    return f"{speed},{draw(curves)},% of Time,{MERGE},0,None"


def changes(kind):
    units = "No,0,No,0,Units per sec,Units per sec2,Units per sec2,Units per sec3"
    return st.builds(f"MCD({{{{}}}},{kind},Yes,{{}},Yes,{{}},No,0,{units})".format, numbers, numbers)


def stops(kind):
    return st.builds(f"MAS({{{{}}}},{kind},Yes,{{}},Units per sec2,No,0,0)".format, numbers)


OF = {
    "Jog": st.one_of(
        st.builds("MAJ({{}},{},{})".format, st.sampled_from(("Forward", "Reverse")), profiles()),
        changes("Jog"),
        stops("Jog"),
    ),
    "Move": st.one_of(
        st.builds("MAM({{}},1,{},{},0,0)".format, st.integers(-40, 40), profiles()),
        changes("Move"),
        stops("Move"),
    ),
    "Gear": st.one_of(
        st.builds("MAG({{}},Same,{},1,1,Command,Real,Disabled,0,0)".format, numbers),
        stops("Gear"),
    ),
}

steps = st.sampled_from(tuple(OF)).flatmap(
    lambda kind: st.tuples(st.just(kind), OF[kind], st.integers(1, 30))
)
SCANS = 40


def program(steps):
    """Return tags and rungs: the rung of a step begins it on both of its axes."""
    axes = ["All", *ALONE.values(), "Master"]
    tags = [f"TAG {axis} : AXIS_VIRTUAL" for axis in axes]
    tags += ["TAG Lead : MOTION_INSTRUCTION", "TAG Go : BOOL"]
    lead = f"MAJ(Master,Lead,0,3,0,1.5,0,2,0,0,100,100,0,{MERGE},0,None)"
    rungs = [f"XIC(Go){lead};"]
    for number, (kind, text, _) in enumerate(steps):
        tags += [f"TAG Go{number} : BOOL"]
        tags += [f"TAG {name}{number} : MOTION_INSTRUCTION" for name in ("With", "Alone")]
        given_to = ((axis, control) for axis, control in (("All", "With"), (ALONE[kind], "Alone")))
        both_of_them = (
            text.format(f"{axis},{'Master,' if text.startswith('MAG') else ''}{control}{number}")
            for axis, control in given_to
        )
        rungs.append(f"XIC(Go{number}){''.join(both_of_them)};")
    return "\n".join(tags), rungs


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.lists(steps, min_size=1, max_size=7))
def test_superimposed_motion_is_the_sum_of_its_parts_alone(steps):
    tags, rungs = program(steps)
    engines = both(tags, *rungs)
    for scan in range(SCANS):
        for engine in engines:
            engine.tags.Go = True
            for number, (_, _, at) in enumerate(steps):
                engine.tags[f"Go{number}"] = scan >= at
            engine.step(70)
            _compare(engine, steps)
        first, second = (engine.tags["All.ActualPosition"] for engine in engines)
        assert first == second


def _compare(engine, steps):
    tags = engine.tags
    for what in ("ActualPosition", "ActualVelocity"):
        alone = sum(tags[f"{axis}.{what}"] for axis in ALONE.values())
        assert tags[f"All.{what}"] == pytest.approx(alone, rel=1e-5, abs=1e-4)
    for kind, axis in ALONE.items():
        assert tags[f"All.{STATUS[kind]}"] == tags[f"{axis}.{STATUS[kind]}"]
    for number, _ in enumerate(steps):
        assert tags[f"With{number}.FLAGS"] == tags[f"Alone{number}.FLAGS"]
        assert tags[f"With{number}.ERR"] == tags[f"Alone{number}.ERR"]


merging = st.tuples(
    st.sampled_from(("Jog", "Move")).flatmap(OF.__getitem__).filter(lambda text: "S-Curve" not in text),
    st.sampled_from(("Disabled,Programmed", "Enabled,Programmed", "Enabled,Current")),
    st.integers(1, 30),
)
all_stop = st.tuples(stops("All"), st.just(MERGE), st.integers(1, 30))


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.lists(st.one_of(merging, all_stop), min_size=1, max_size=7))
def test_speed_does_not_jump_whatever_merges(steps):
    """No rate is above 5 units/s², of move, jog and the stop of all: 15 in sum."""
    names = [f"Do{number}" for number in range(len(steps))]
    tags = [
        "TAG All : AXIS_VIRTUAL",
        *(f"TAG {name} : MOTION_INSTRUCTION\nTAG Go{name} : BOOL" for name in names),
    ]
    rungs = [
        f"XIC(Go{name}){text.format(f'All,{name}').replace(MERGE, merge)};"
        for name, (text, merge, _) in zip(names, steps, strict=True)
    ]
    engines, before = both("\n".join(tags), *rungs), 0.0
    for scan in range(SCANS):
        for engine in engines:
            for name, (_, _, at) in zip(names, steps, strict=True):
                engine.tags[f"Go{name}"] = scan >= at
            engine.step(70)
        first, second = ([engine.tags[name] for name in ("All", *names)] for engine in engines)
        assert first == second
        speed = engines[0].tags["All.ActualVelocity"]
        assert abs(speed - before) <= 15 * 0.07 + 1e-4
        before = speed
