"""Test of the line. Run it with pytest."""


def test_it_goes_out_and_back_at_a_press(rack):
    line = rack("rack.toml")
    line.run_until(lambda bench: bench.slot[1].status.position == 4000, within="8 s")
    line.run_until("Rounds.ACC", within="5 s")
    assert line.slot[1].status.position == 0
