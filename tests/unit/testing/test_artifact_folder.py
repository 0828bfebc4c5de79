"""The folders of tests: safe names, and nothing of others is removed."""

import pytest
from scanrack.testing.folder import DIGEST, LONGEST, MARK, PASSED, ArtifactFolder, folder_names, remove_base
from scanrack.traces.files.guard import OwnedError
from scanrack.traces.files.locking import could_lock
from scanrack.traces.format.records import MAGIC

HOSTILE = [
    "test_a.py::test_it[../../etc/passwd]",
    "test_a.py::test_it[/etc/passwd]",
    "../outside/test_a.py::test_it",
    f"test_a.py::test_it[{'x' * 300}]",
    "test_a.py::test_it[a/b]",
    "test_a.py::test_it[a-b]",
    "test_a.py::test_it[a b]",
    "test_a.py::test_it[\x00\n\x1b[31m]",
    "test_a.py::test_it[\udcff]",
    "test_a.py::test_it[äöü]",
    "test_a.py::test_it[...]",
    "::[]",
    "test_a.py--test_it",
    "test_a.py::test_it",
    "a/b.py::c",
    "a-b.py::c",
    "a::b.py::c",
]


def test_a_plain_test_has_a_plain_folder():
    assert folder_names("tests/test_a.py::TestX::test_it")[0] == "tests-test_a.py--TestX--test_it"


@pytest.mark.parametrize("test", HOSTILE, ids=range(len(HOSTILE)))
def test_a_name_stays_a_name_in_its_folder(tmp_path, test):
    for name in folder_names(test):
        assert len(name) <= LONGEST + 1 + DIGEST
        assert name.isascii()
        assert name.isprintable()
        assert not set(name) & set("/\\: []")
        assert name[0] not in ".-" or test == "::[]"
        assert (tmp_path / name).resolve().parent == tmp_path.resolve()
    assert ArtifactFolder(tmp_path, test).path.is_dir()


def test_different_tests_have_different_folders(tmp_path):
    paths = {ArtifactFolder(tmp_path, test).path for test in HOSTILE}
    assert len(paths) == len(HOSTILE)


def test_the_next_run_finds_its_folder_empty(tmp_path):
    first = ArtifactFolder(tmp_path, "t.py::a").path
    (first / "old.mcap").write_bytes(MAGIC)
    second = ArtifactFolder(tmp_path, "t.py::a").path
    assert second == first
    assert [each.name for each in second.iterdir()] == [MARK]


@pytest.mark.parametrize("marked", [None, "t.py::A"], ids=["the user's", "another test's"])
def test_a_folder_of_others_is_left_alone(tmp_path, marked):
    own = tmp_path / "t.py--a"
    own.mkdir()
    (own / "thesis.txt").write_text("words", encoding="utf-8")
    if marked is not None:
        (own / MARK).write_text(marked, encoding="utf-8")
    folder = ArtifactFolder(tmp_path, "t.py::a")
    assert folder.path != own  # it takes the name with the digest
    folder.remove()
    assert (own / "thesis.txt").read_text(encoding="utf-8") == "words"


def test_a_file_and_a_link_are_left_alone(tmp_path):
    target = tmp_path / "target"
    target.mkdir()
    (target / MARK).write_text("t.py::a", encoding="utf-8")  # as if it were the test's own
    plain, unique = folder_names("t.py::a")
    base = tmp_path / "base"
    base.mkdir()
    (base / plain).symlink_to(target)
    (base / unique).write_text("a file", encoding="utf-8")
    with pytest.raises(OwnedError, match=r"was not made by scanrack for t\.py::a"):
        _ = ArtifactFolder(base, "t.py::a").path
    assert (target / MARK).exists()
    assert (base / unique).read_text(encoding="utf-8") == "a file"


@pytest.mark.parametrize("passed", [True, False])
def test_a_link_in_the_place_of_the_run_that_passed_is_removed_and_its_target_kept(tmp_path, passed):
    (target := tmp_path / "elsewhere").mkdir()
    (target / "run.mcap").touch()
    first = ArtifactFolder(tmp_path / "base", "t.py::a")
    (first.path / "run.mcap").touch()
    if passed:
        first.keep_passed()
    (first.path / PASSED).symlink_to(target)
    again = ArtifactFolder(tmp_path / "base", "t.py::a")
    kept = again.passed_trace(again.path / "run.mcap")
    assert kept == (again.path / PASSED / "run.mcap" if passed else None)
    assert not (again.path / PASSED).is_symlink()
    assert [each.name for each in target.iterdir()] == ["run.mcap"]


def test_a_folder_that_another_run_is_recording_to_is_refused(tmp_path):
    first = ArtifactFolder(tmp_path, "t.py::a").path
    with (first / "run.mcap").open("wb") as file:
        assert could_lock(file.fileno())
        with pytest.raises(OwnedError, match="is being recorded by another run"):
            _ = ArtifactFolder(tmp_path, "t.py::a").path


def test_a_folder_that_lost_its_mark_is_not_removed(tmp_path):
    folder = ArtifactFolder(tmp_path, "t.py::a")
    (folder.path / MARK).unlink()
    folder.remove()
    assert (tmp_path / "t.py--a").is_dir()


def test_the_base_goes_if_scanrack_made_it_and_it_is_empty(tmp_path):
    base = tmp_path / "new" / "base"
    folder = ArtifactFolder(base, "t.py::a")
    assert folder.path.parent == base
    remove_base(base)
    assert base.is_dir()
    folder.remove()
    remove_base(base)
    assert not base.exists()


@pytest.mark.parametrize("inside", [{}, {".gitignore": "build/\n"}, {"notes.txt": ""}], ids=str)
def test_a_base_of_the_users_stays(tmp_path, inside):
    for name, text in inside.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    ArtifactFolder(tmp_path, "t.py::a").path.joinpath("x").touch()
    ArtifactFolder(tmp_path, "t.py::a").remove()
    folder = ArtifactFolder(tmp_path, "t.py::a")
    assert folder.path
    folder.remove()
    remove_base(tmp_path)
    assert {each.name for each in tmp_path.iterdir()} == set(inside)
