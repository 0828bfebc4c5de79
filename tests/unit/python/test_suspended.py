"""What the open blocks of a waiting frame hold, by kind of block: CPython decides how its stack looks."""

import threading
from collections.abc import Generator
from contextlib import contextmanager, nullcontext, suppress

import pytest
from scanrack.ladder.python.online.suspended import BlockKind, UnknownStackError, suspended


class Pause:
    def __await__(self) -> Generator[None]:
        yield


class Own:
    """A context manager, of both kinds."""

    def __enter__(self):
        return self

    def __exit__(self, *about):
        return None

    async def __aenter__(self):
        return self

    async def __aexit__(self, *about):
        return None


@contextmanager
def made():
    yield


async def in_with(block):
    with block:
        await Pause()


async def in_async_with(block):
    async with block:
        await Pause()


async def in_all(block, turns):
    for _ in turns:
        async with block:
            try:
                raise ValueError("handled")
            except ValueError:
                with block:
                    await Pause()


def waiting(work):
    work.send(None)
    return suspended(work)


def finish(work):
    with pytest.raises(StopIteration):
        work.send(None)


@pytest.mark.parametrize("block", [Own(), nullcontext(), suppress(KeyError), threading.Lock(), made()])
def test_of_a_with_block_its_exit(block):
    work = in_with(block)
    (leave,) = waiting(work).block_objects([BlockKind.EXIT])
    assert leave.__self__ is block
    assert leave.__name__ == "__exit__"
    finish(work)


def test_of_an_async_with_block_its_exit():
    block = Own()
    work = in_async_with(block)
    (leave,) = waiting(work).block_objects([BlockKind.EXIT])
    assert (leave.__self__, leave.__name__) == (block, "__aexit__")
    finish(work)


def test_of_blocks_in_blocks_each_its_own():
    block, turns = Own(), iter((1,))
    work = in_all(block, turns)
    frame = waiting(work)
    iterator, outer, error, inner = frame.block_objects(
        [BlockKind.ITERATOR, BlockKind.EXIT, BlockKind.HANDLER, BlockKind.EXIT]
    )
    assert iterator is turns
    assert (outer.__self__, outer.__name__) == (block, "__aexit__")
    assert (inner.__self__, inner.__name__) == (block, "__exit__")
    assert str(error) == "handled"
    finish(work)


@pytest.mark.parametrize("kinds", [[BlockKind.ITERATOR], [BlockKind.EXIT] * 2, [BlockKind.HANDLER]])
def test_a_stack_that_is_not_as_expected_is_refused(kinds):
    work = in_with(Own())
    with pytest.raises(UnknownStackError):
        waiting(work).block_objects(kinds)
    finish(work)
