"""The blinker keeps the contract of a module: any outputs, time in pieces, its names. Run it with pytest."""

from pathlib import Path

from scanrack.testing.modules import check_module, record_in


def test_it_keeps_the_contract() -> None:
    check_module(record_in(Path(__file__).with_name("blinker.py")))
