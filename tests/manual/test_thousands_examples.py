"""The manual's worked examples of the thousands words."""

import pytest
from scanrack.io_images.thousands import (
    PARAMETER_MAX,
    PARAMETER_MIN,
    is_legal_pair,
    join_reported,
    join_thousands,
    split_reported,
    split_thousands,
)

# Value, MSW, LSW; printed twice with the same five rows.
TABLE = [(-12_345, -12, -345), (12_000, 12, 0), (-12_000, -12, 0), (345, 0, 345), (-345, 0, -345)]


@pytest.mark.parametrize(
    ("value", "msw", "lsw"),
    [pytest.param(*row, id=f"Module Overview and chapter 5 note 3: {row[0]}") for row in TABLE],
)
def test_table_of_values(value, msw, lsw):
    assert split_thousands(value) == (msw, lsw)
    assert join_thousands(msw, lsw) == value
    assert split_reported(value) == (msw, lsw)
    assert join_reported(msw, lsw) == value


def test_starting_speed_example():
    """Chapter 3 note 3: 12,345 steps/s has an MSW of 12 and an LSW of 345."""
    assert split_thousands(12_345) == (12, 345)


@pytest.mark.parametrize(
    ("msw", "lsw", "legal"),
    [
        pytest.param(0, 999, True, id="chapter 5 note 5: LSW up to 999"),
        pytest.param(0, -999, True, id="chapter 5 note 5: LSW down to -999"),
        pytest.param(0, 1000, False, id="chapter 5 note 5: LSW 1000"),
        pytest.param(0, -1000, False, id="chapter 5 note 5: LSW -1000"),
        pytest.param(-1, 1, False, id="chapter 6 Command Error 4: MSW negative, LSW positive"),
        pytest.param(1, -1, False, id="chapter 6 Command Error 4: MSW positive, LSW negative"),
        pytest.param(-1, 0, True, id="chapter 6 Command Error 4: MSW negative, LSW zero"),
        pytest.param(0, -1, True, id="chapter 6 Command Error 4: MSW zero, LSW negative"),
    ],
)
def test_legal_pairs(msw, lsw, legal):
    assert is_legal_pair(msw, lsw) is legal
    if not legal:
        with pytest.raises(ValueError, match=f"words \\({msw}, {lsw}\\) are not a value"):
            join_thousands(msw, lsw)


def test_range_of_position_parameters():
    """Chapter 5 note 4: -8,388,608 to 8,388,607, the range of 24 bits."""
    assert (PARAMETER_MIN, PARAMETER_MAX) == (-(2**23), 2**23 - 1)
    assert split_thousands(PARAMETER_MIN) == (-8388, -608)
    assert split_thousands(PARAMETER_MAX) == (8388, 607)


@pytest.mark.parametrize(
    ("value", "msw"),
    [
        pytest.param(32_767_999, 0x7FFF, id="chapter 6 Current Position: last positive MSW"),
        pytest.param(32_768_999, 0x8000 - 0x10000, id="chapter 6 Current Position: 7FFFh to 8000h"),
        pytest.param(65_535_999, 0xFFFF - 0x10000, id="chapter 6 Current Position: greatest position"),
        pytest.param(65_536_999, 0, id="beyond it the 16 bits begin again"),
    ],
)
def test_reported_msw_uses_all_16_bits(value, msw):
    """The LSW is 999 throughout: its sign is that of the value, not of the MSW."""
    assert split_reported(value) == (msw, 999)
    if value <= 65_535_999:
        assert join_reported(msw, 999) == value
        assert join_reported(*split_reported(-value)) == -value
