"""What `Amci3601Options` refuses, and in which words."""

from __future__ import annotations

import pytest
from scanrack.runtime import Amci3601
from scanrack.runtime.modules.amci3601 import Amci3601Options


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"input_scan": 250}, r"option input_scan: .* no such option; did you mean input_scan_us\?"),
        (
            {"turbo": True},
            r"option turbo: .* no such option; choose from input_scan_us, .*, home_reversal_dwell_ms",
        ),
        ({"input_scan_us": 49}, "option input_scan_us: 49 is out of range: 50 to 250000"),
        ({"input_scan_us": 250_001}, "option input_scan_us: 250001 is out of range: 50 to 250000"),
        ({"input_scan_us": True}, "option input_scan_us: True is not a whole number"),
        ({"input_scan_us": 250.0}, "option input_scan_us: 250.0 is not a whole number"),
        ({"home_reversal_dwell_ms": -1}, "option home_reversal_dwell_ms: -1 is out of range: 0 and more"),
        ({"stopped_after_config": 1}, "option stopped_after_config: 1 is not true or false"),
        ({"stopped_after_config": None}, "option stopped_after_config: None is not true or false"),
    ],
)
def test_refusals_name_the_switch_its_value_and_what_is_allowed(given, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        Amci3601(options=given)


@pytest.mark.parametrize(
    "given", [{"input_scan_us": 50}, {"input_scan_us": 250_000}, {"home_reversal_dwell_ms": 0}]
)
def test_the_ends_of_the_ranges_are_allowed(given):
    (name,) = given
    assert getattr(Amci3601Options.of(given), name) == given[name]


def test_no_options_are_the_defaults():
    assert Amci3601Options.of(None) == Amci3601Options.of({}) == Amci3601Options() == Amci3601().options
