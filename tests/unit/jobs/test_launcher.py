"""Helper processes: what is handed to them, and which keys of a console end them."""

import signal
import socket
import sys
import types

import pytest
from scanrack.jobs.trust import launcher
from scanrack.runtime.live.shared_memory import SharedMemory


def answer(given, memory, word):
    """Write what is in the memory, and a word, to a socket: the main function of a helper."""
    assert isinstance(memory, SharedMemory)
    given.sendall(memory.map[:5] + word.encode())
    memory.map[:5] = b"taken"


def say_how_break_is_handled():
    sys.stdout.write(str(signal.getsignal(signal.SIGQUIT)))


def test_sockets_and_memory_are_handed_over_before_the_words():
    mine, theirs = socket.socketpair()
    memory = SharedMemory(64)
    memory.map[:5] = b"given"
    with mine, launcher.launch(f"{__name__}:answer", "word", handed=[theirs, memory]) as helper:
        theirs.close()
        heard = b""
        while part := mine.recv(64):
            heard += part
    assert (helper.returncode, heard, memory.map[:5]) == (0, b"givenword", b"taken")
    memory.close()


def test_a_helper_that_has_died_at_once_is_seen_by_its_status():
    memory = SharedMemory(64)
    with launcher.launch("scanrack.nowhere:main", handed=[memory], stderr=launcher.PIPE) as helper:
        assert b"scanrack.nowhere" in helper.communicate()[1]
    assert helper.returncode == 1
    memory.close()


def test_ctrl_break_of_a_console_does_not_end_a_helper(monkeypatch):
    monkeypatch.setattr(signal, "SIGBREAK", signal.SIGQUIT, raising=False)  # which forked helpers have, too
    with launcher.launch(f"{__name__}:say_how_break_is_handled", stdout=launcher.PIPE) as helper:
        assert helper.communicate()[0] == str(signal.SIG_IGN).encode()


@pytest.mark.parametrize(("own_session", "flags"), [(True, 0x200), (False, 0)])
def test_a_helper_with_its_own_session_is_in_a_group_of_its_own_on_windows(monkeypatch, own_session, flags):
    given = {}
    module = types.SimpleNamespace(Popen=lambda _words, **options: given.update(options) or _Dead())
    module.CREATE_NEW_PROCESS_GROUP, module.DEVNULL = 0x200, -3
    monkeypatch.setattr(launcher, "subprocess", module)
    launcher.launch("a:b", own_session=own_session)
    assert (given["creationflags"], given["start_new_session"]) == (flags, own_session)


class _Dead:
    stdin = None
