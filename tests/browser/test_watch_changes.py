"""◀ and ▶ look at the previous and the next change of a tag or a bit.

Broken on purpose: `value !== before` of changes.js, the scan before a change: a test turns red.
"""

import pytest
from scanrack.jobs import open_bench

SCANS = 2000
READS = {
    "Axis.State": lambda bench: bench["Axis.State"],
    "Local:1:I.Data[0].0": lambda bench: bool(bench.slot[1].inputs[0] & 1),  # MOVING_CW
}


@pytest.fixture(scope="module")
def expected(feeder_rack):
    """The scans after the first in which each value changes, as a bench shows it."""
    bench = open_bench(feeder_rack)
    values: dict[str, list[object]] = {name: [] for name in READS}
    for _ in range(SCANS):
        bench.scan()
        for name, read in READS.items():
            values[name].append(read(bench))
    return {
        name: [scan for scan in range(1, SCANS) if each[scan] != each[scan - 1]]
        for name, each in values.items()
    }


def test_the_way_leads_from_change_to_change_and_back(page, paused, expected):
    page.open(paused.link, paused=True)
    page.step(SCANS)
    page.until_scan(SCANS - 1, "paused")
    for name, scans in expected.items():
        assert len(scans) >= 3
        page.run("return import('/scrub.js').then(scrub => scrub.lookAt(1))")
        page.until_scan(1, "past")
        page.run("const [tag] = arguments; import('/selection.js').then(all => all.select({ tag }))", name)
        page.until_there("#tag[data-selected]")
        later = [scan for scan in scans if scan > 1][:4]
        for scan in later:
            page.press("Next change")
            page.until_scan(scan, "past")
        for scan in later[-2::-1]:
            page.press("Previous change")
            page.until_scan(scan, "past")
