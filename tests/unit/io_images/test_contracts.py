"""The table of contracts: sources, reach, what a row depends on, and that no row is true of all images."""

from __future__ import annotations

from random import Random

import pytest
from bench3601 import HOME_CW, Bench, configuration
from contracts3601 import check_of
from scanrack.io_images.amci3601 import RULES
from scanrack.io_images.amci3601.contracts import CONTRACTS, Side, broken, contracts_of
from scanrack.runtime.modules.amci3601.amci3601_options import Amci3601Options

POWER_UP = (0x6400, 0, 0, 0, 0, 0, 0, 0)


def words_at_random(dice):
    """Words with few bits in the first two, in command mode mostly."""
    bits = [1 << dice.randrange(16) | 1 << dice.randrange(16) for _ in range(2)]
    return (
        bits[0] | dice.choice((0x4000, 0x4000, 0)),
        bits[1],
        *(dice.choice((0, 5, 1000)) for _ in range(6)),
    )


@pytest.mark.parametrize("row", CONTRACTS, ids=lambda row: row.name)
def test_a_row_names_its_rules_and_can_be_broken(row):
    assert row.rules
    assert set(row.rules) <= set(RULES)
    assert set(row.readings) <= set(Amci3601Options.model_fields)
    assert all(Amci3601Options.model_fields[name].default == value for name, value in row.readings.items())
    dice = Random(1)
    images = ([words_at_random(dice) for _ in range(3)] for _ in range(20_000))
    assert any(not row.fact.holds(*each) for each in images)


def test_names_are_different():
    assert len({row.name for row in CONTRACTS}) == len(CONTRACTS)


@pytest.mark.parametrize(("each_update", "sides"), [(False, {Side.NOW}), (True, set(Side))])
def test_a_row_that_speaks_of_two_images_needs_each_update(each_update, sides):
    chosen = contracts_of(each_update=each_update)
    assert {side for row in chosen for side in row.fact.images} == sides


def test_the_image_of_a_power_up_keeps_all():
    assert broken(POWER_UP, POWER_UP, (0,) * 8) == ()
    assert broken(POWER_UP) == ()


def test_a_lost_position_without_stopped_is_broken_only_by_two_images():
    """Chapter 6, Position Invalid 2 and Stopped 3: Immediate Stop sets both."""
    lost, moving, both = (0x4400, *(0,) * 7), (0x4001, *(0,) * 7), (0x4408, *(0,) * 7)
    assert [row.name for row in broken(lost, moving)] == ["position lost"]
    assert broken(lost) == broken(both, moving) == ()


def named(name):
    """The row of a name."""
    (row,) = (row for row in CONTRACTS if row.name == name)
    return row


def test_words_may_be_signed_or_not():
    row = named("two words")
    assert row.fact.holds((0x4000, 0, 0, 0xFFFF, 0, -1, 0, 0))
    assert not row.fact.holds((0x4000, 0, 0, 0x8000, 0, 0, 0, 0))


def home_and_configure(bench):
    """At Home, then configuration mode and back."""
    bench.command(HOME_CW, speed=2000, up=100, down=100).until("AT_HOME")
    bench.out(*configuration()).run(2)
    bench.idle(2)


def complete_and_misconfigure(bench):
    """Move Complete, then a configuration without limits, and back."""
    bench.relative(10, up=100, down=100).until("MOVE_COMPLETE")
    bench.out(*configuration(drop=0x30)).run(2)
    bench.idle(2)


def move_with_an_unused_input(bench):
    """The emergency stop is not used; it is active, and the axis moves."""
    bench.out(*configuration(drop=0x08)).run(2)
    bench.idle(2)
    bench.inputs(estop=1).relative(1000).run(4)
    bench.run(2)


def leave_run_mode(bench):
    """Program mode in mid-move."""
    bench.relative(1000).run(20)
    bench.plc("program").run(2)


OTHER_READINGS = {
    ("home is valid", "clear_status_after_config"): home_and_configure,
    ("nothing before a configuration", "clear_status_after_config"): complete_and_misconfigure,
    ("emergency stop", "report_unused_inputs"): move_with_an_unused_input,
    ("position lost", "stopped_after_program_mode"): leave_run_mode,
}


@pytest.mark.parametrize(("name", "option"), [(row.name, each) for row in CONTRACTS for each in row.readings])
def test_a_row_that_needs_a_reading_falls_with_the_other_one(name, option):
    row = named(name)
    other = {option: not row.readings[option]}
    assert row not in contracts_of(other)
    assert not held_in(OTHER_READINGS[name, option], row, {option: row.readings[option]})
    assert held_in(OTHER_READINGS[name, option], row, other)


def held_in(story, row, options):
    """Return the images of a story that break a row."""
    bench = Bench.ready(machine={"home": (300, 500)}, **options)
    found, check = [], check_of((row,))
    advance = bench.module.update

    def update(now_ns, outputs):
        was = tuple(bench.image)
        now = advance(now_ns, outputs)
        found.extend(check(tuple(now), was, tuple(outputs)))
        return now

    bench.module.update = update  # type: ignore[method-assign]
    bench.image = bench.image.copy()
    story(bench)
    return found
