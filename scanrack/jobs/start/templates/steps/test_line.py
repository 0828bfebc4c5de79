"""Test of the line. Run it with pytest."""


def test_it_goes_out_and_back(rack):
    line = rack("rack.toml")
    axis = line.slot[1]
    line.run_until(lambda _bench: axis.status.position == 4000, within="8 s")
    line.run_until(lambda _bench: axis.status.MOVE_COMPLETE and not axis.status.position, within="8 s")
    assert axis.shaft == -1300  # where the home switch is
