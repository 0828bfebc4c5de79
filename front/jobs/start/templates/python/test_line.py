"""What the line has to do. Run it with pytest."""

from pathlib import Path

from scanrack import open_bench

RACK = Path(__file__).with_name("rack.toml")


def test_it_goes_out_and_back_at_a_press() -> None:
    with open_bench(RACK) as line:
        line.run_until(lambda bench: bench.slot[1].status.position == 4000, within="8 s")
        line.run_until("shuttle.rounds", within="5 s")
        assert line.slot[1].status.position == 0
