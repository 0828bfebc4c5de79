"""A follower that sleeps while nothing moves, beside the same module with a tick in every scan of its own."""

from fractions import Fraction
from random import Random

import pytest
from scanrack.io_images.amci3601 import Configuration, Direction, Follower, Idle, InputBit, ResetErrors
from scanrack.runtime import Amci3601
from scanrack.runtime.machine import EncoderSpec, Machine, MachineSpec, Switch

CW, CCW = Direction.CW, Direction.CCW
MS = 1_000_000
TICK_NS = MS // 4
READY = Configuration(
    inputs_used=InputBit.HOME | InputBit.CW_LIMIT | InputBit.CAPTURE,
    step_and_direction=True,
    quadrature_encoder=True,
    starting_speed=500,
)
EXCHANGES = 150


class EveryTick(Amci3601):
    """A 3601 that looks at its words, its inputs and its encoder in every scan of 250 us."""

    def _next_tick(self, tick_ns):
        return tick_ns + TICK_NS

    def _next_counts(self, now_ns):
        wanted = self.layer.counts_from_ns(now_ns, now_ns) is not None or self.layer.operation is not None
        return now_ns + TICK_NS if wanted else super()._next_counts(now_ns)


def both(encoder=None):
    spec = MachineSpec(
        switches=(Switch(InputBit.CW_LIMIT, 5000), Switch(InputBit.CAPTURE, 20, 60)), encoder=encoder
    )
    return [kind("4.1", Machine(spec)) for kind in (Amci3601, EveryTick)]


def words(random):
    if random.random() < 0.3:
        return random.choice((Idle(), ResetErrors())).to_image()
    rates = random.choice(((0, 0), (50, 50), (2000, 1), (0, 30)))
    way, multiplier = random.choice((CW, CW, CCW, None)), random.choice((1, 3, 50))
    return Follower(way, multiplier, random.choice((1, 7, 100)), *rates).to_image()


@pytest.mark.parametrize("seed", range(5))
def test_a_follower_asleep_shows_what_one_awake_shows(seed):
    random = Random(seed)
    modules = both(EncoderSpec(Fraction(1)) if seed % 3 == 2 else None)
    outputs, now_ns, free_ns, positions = READY.to_image(), 0, 0, set()
    for exchange in range(EXCHANGES):
        now_ns += random.choice((1, 333_333, MS, 2 * MS, 7 * MS))
        images = [list(module.update(now_ns, outputs)) for module in modules]
        assert images[0] == images[1], (seed, exchange, now_ns)
        positions.add(images[0][3])
        if exchange > 5 and (exchange == 6 or random.random() < 0.12):
            outputs = words(random)
        if random.random() < 0.15 and now_ns >= free_ns:
            begin_ns = now_ns + random.choice((0, 0, TICK_NS, 777_777, 9 * MS))
            free_ns = begin_ns + random.choice((1, 300_001, 20 * MS, 80 * MS))
            counts = random.choice((1, -1, 3, 40, -40, 1000))
            for module in modules:
                module.machine.turn_encoder(counts, begin_ns, free_ns)
    assert len(positions) > 4


def test_a_follower_at_rest_has_nothing_to_do():
    module, _ = both()
    module.update(10 * MS, READY.to_image())
    follows = Follower(CW, 1, 1).to_image()
    for now_ns in range(12 * MS, 20 * MS, 2 * MS):
        module.update(now_ns, follows)
    assert module.calm_until_ns(follows) > 1000 * MS
    module.machine.turn_encoder(5, 20 * MS, 21 * MS)
    assert module.update(22 * MS, follows)[3] == 5
