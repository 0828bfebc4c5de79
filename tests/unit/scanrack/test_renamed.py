"""Old names of the public interface work for one release, warn, and mean what the new ones mean."""

from __future__ import annotations

from importlib import import_module

import pytest
from scanrack.io_images.renamed import RENAMED, OldName


def home_of(path: str) -> tuple[object, str]:
    """Return the module or class of a dotted path, and the last name."""
    owner, _, name = path.rpartition(".")
    try:
        return import_module(owner), name
    except ModuleNotFoundError:
        module, _, kind = owner.rpartition(".")
        return getattr(import_module(module), kind), name


@pytest.mark.parametrize("path", RENAMED)
def test_an_old_name_warns_and_is_the_new_one(path):
    home, old = home_of(path)
    new = RENAMED[path]
    if isinstance(home, type):
        assert isinstance(vars(home)[old], OldName)
        assert new in {*vars(home), *vars(home)["__init__"].__code__.co_names}
        return
    with pytest.warns(DeprecationWarning, match=f"^{old} is now {new}$") as caught:
        found = getattr(home, old)
    assert caught[0].filename == __file__
    assert found is getattr(home, new)
    assert old not in dir(home)


def test_unknown_names_are_still_refused():
    for name in ("scanrack.runtime.line.clients.link", "scanrack.traces.replay", "scanrack"):
        module = import_module(name)
        with pytest.raises(AttributeError, match=f"^module '{name}' has no attribute 'Nonsense'"):
            module.Nonsense  # noqa: B018


def test_an_old_method_of_a_bench_warns_where_it_is_used(rack):
    bench = rack("../../../examples/feeder/feeder.toml")
    bench.run_for("1 ms")
    with pytest.warns(DeprecationWarning, match=r"^told is now events$") as caught:
        assert bench.told is bench.events
    assert caught[0].filename == __file__
    with pytest.warns(DeprecationWarning, match=r"^fail is now inject$"):
        bench.slot[1].fail("link-lost")
    bench.run_for("10 ms")
    assert any(each.name == "link-lost" for each in bench.events)
