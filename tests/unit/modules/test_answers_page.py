"""docs/incidents.md says bit by bit what the PLC sees of a module in trouble: as the simulation does it."""

from answers_page import PAGE, REMEDY, written
from bench3601 import Bench
from scanrack.io_images.amci3601 import StatusMsw
from scanrack.runtime.loop.module_fault import ModuleFault
from scanrack.runtime.modules.amci3601.trouble import FAULT_IMAGES


def test_the_page_has_the_table_as_it_is():
    page = PAGE.read_text(encoding="utf-8")
    assert written(page) == page, REMEDY


def test_a_lost_link_leaves_module_ok_and_freezes_the_status():
    bench = Bench.ready().relative(10_000).run(500)
    before = list(bench.words)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.run(500)
    assert list(bench.words) == before
    assert before[0] & StatusMsw.MODULE_OK.value
    assert not bench.module.linked


def test_a_fault_never_sets_a_bit():
    for fault in ModuleFault:
        bench = Bench.ready().relative(10_000).run(500)
        before = [word & 0xFFFF for word in bench.words]
        bench.module.inject(fault)
        bench.run(1)
        seen = [word & 0xFFFF for word in bench.words]
        assert all(now & ~was == 0 for now, was in zip(seen, before, strict=True))
        assert all(now & ~kept == 0 for now, kept in zip(seen, FAULT_IMAGES[fault].kept, strict=True))
