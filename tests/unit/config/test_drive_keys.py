"""A wrong key of a rack with a networked drive is named: file, line, key, value and what is allowed."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.runtime.config.rackfile import load_rack_file

RACK = 'name = "bench"\nprogram = "none.py"\n\n[[slot]]\nnumber = 1\nmodule = "{}"\n{}\n'


@pytest.mark.parametrize(
    ("module", "line", "message"),
    [
        ("amci-drive", 'options = { model = "anf2" }', 'options.model = "anf2": .*: smd23e2, smd24e2'),
        ("amci-drive", "options = { axis = 13 }", "options.axis = 13: .*: 1 to 12"),
        ("amci-drive", 'options = { in1 = "in1" }', 'options.in1 = "in1": .*allowed: none, capture'),
        ("amci-drive", "options = { rpi_ms = 0 }", "options.rpi_ms = 0: .*: 1 to 100"),
        ("amci-drive", "options = { current = 35 }", "options.current = 35: .*: 10 to 34"),
        ("amci-drive", "options = { unit = 1 }", "options.unit = 1: .*choose from model, axis, in1, in2"),
        ("amci-drive", 'port = "tcp:drive"', 'port = "tcp:drive": .*must be tcp:HOST:PORT'),
        ("amci-drive", 'address = 256\nport = "tcp:a:502"', "address = 256: .*: must be 1 to 247"),
        ("amci-drive", 'host = "drive"', "host: unknown key; choose from .*port, address"),
        ("smd23e2", 'options = { in3 = "home" }', 'options.in3 = "home": .*did you mean in2'),
        (
            "smd23e2",
            "options = { stored = [1, 2] }",
            r"options.stored: .*\[1, 2\].*: must be empty or 10 words of 0 to 65535",
        ),
        ("smd23e2", 'port = "tcp:a:502"', 'port = "tcp:a:502": .*smd23e2 has no port; only .*amci-drive'),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(tmp_path: Path, module: str, line: str, message: str) -> None:
    rack = tmp_path / "rack.toml"
    rack.write_text(RACK.format(module, line), encoding="utf-8", newline="\n")
    with pytest.raises(ValueError, match=rf"rack\.toml:7: slot\.{message}"):
        load_rack_file(rack)
