"""Machine code on disk: only the user's own files are loaded, and the folder does not grow without end."""

import logging
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from symfric.codegen import object_cache

posix = pytest.mark.skipif(os.name != "posix", reason="owners and permissions of files are those of POSIX")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("SYMFRIC_CACHE_SIZE", raising=False)
    monkeypatch.setattr(object_cache, "_stored", {})
    object_cache._say_once.cache_clear()
    return tmp_path / "cache"


def said(caplog) -> list[str]:
    return [r.getMessage() for r in caplog.records if r.name == "symfric" and r.levelno == logging.WARNING]


def test_what_is_stored_is_loaded(folder):
    assert object_cache.load("key") is None
    object_cache.store("key", b"code")
    assert object_cache.load("key") == b"code"
    assert [p.name for p in folder.iterdir()] == ["key.o"]


@posix
def test_the_folder_and_its_files_are_the_users_alone(folder):
    before = os.umask(0)
    try:
        object_cache.store("key", b"code")
    finally:
        os.umask(before)
    assert folder.stat().st_mode & 0o777 == 0o700
    assert (folder / "key.o").stat().st_mode & 0o777 == 0o600


@posix
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o720, 0o1777])
def test_a_folder_that_others_can_write_is_not_used(folder, mode, caplog):
    object_cache.store("key", b"code")
    folder.chmod(mode)
    assert object_cache.load("key") is None
    object_cache.store("other", b"code")
    assert object_cache.load("other") is None
    assert [p.name for p in folder.iterdir()] == ["key.o"]
    assert said(caplog) == [
        f"compiled code is neither loaded nor kept: {folder} can be written by other users; "
        "make it yours alone (chmod 700), or name another in SYMFRIC_CACHE_DIR"
    ]
    folder.chmod(0o755)
    assert object_cache.load("key") == b"code"


@posix
def test_a_file_that_others_can_write_is_not_loaded_but_replaced(folder):
    object_cache.store("key", b"code")
    for mode in (0o620, 0o602, 0o666):
        (folder / "key.o").chmod(mode)
        assert object_cache.load("key") is None
    object_cache.store("key", b"code again")
    assert object_cache.load("key") == b"code again"


@posix
def test_what_another_user_owns_is_not_used(folder, monkeypatch, caplog):
    object_cache.store("key", b"code")
    with monkeypatch.context() as patch:
        patch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1)
        assert object_cache.load("key") is None
        object_cache.store("other", b"code")
    assert [p.name for p in folder.iterdir()] == ["key.o"]
    assert "belongs to another user" in said(caplog)[0]
    assert len(said(caplog)) == 1
    assert object_cache.load("key") == b"code"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("given", ["folder", "file"])
def test_what_was_given_to_another_user_is_not_used(folder, given):
    object_cache.store("key", b"code")
    os.chown(folder if given == "folder" else folder / "key.o", 12345, 12345)
    assert object_cache.load("key") is None


@posix
def test_links_are_followed_to_folders_of_the_user_alone(folder, tmp_path, monkeypatch):
    object_cache.store("key", b"code")
    link = tmp_path / "link"
    link.symlink_to(folder)
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(link))
    assert object_cache.load("key") == b"code"
    folder.chmod(0o777)
    assert object_cache.load("key") is None
    folder.chmod(0o700)
    real = os.lstat

    def foreign(place, **arguments):
        found = real(place, **arguments)
        return os.stat_result((*found[:4], found.st_uid + 1, *found[5:])) if Path(place) == link else found

    with monkeypatch.context() as patch:
        patch.setattr(os, "lstat", foreign)
        patch.setattr(Path, "lstat", lambda self: foreign(self))
        assert object_cache.load("key") is None
    assert object_cache.load("key") == b"code"


@posix
def test_a_file_that_is_a_link_a_folder_or_a_pipe_is_not_loaded(folder, tmp_path):
    object_cache.store("key", b"code")
    (tmp_path / "elsewhere").write_bytes((folder / "key.o").read_bytes())
    (folder / "link.o").symlink_to(tmp_path / "elsewhere")
    (folder / "folder.o").mkdir()
    os.mkfifo(folder / "pipe.o")
    for name in ("link", "folder", "pipe"):
        assert object_cache.load(name) is None
    object_cache.store("link", b"mine")
    assert object_cache.load("link") == b"mine"
    assert not (folder / "link.o").is_symlink()


COMPILE = """
import casadi as ca
from symfric.codegen.functions import compile_functions
x = ca.SX.sym("x")
print(compile_functions([ca.Function("square", [x], [x * x])]).cached)
"""


@pytest.mark.long(beside="test_a_folder_that_others_can_write_is_not_used")
def test_without_a_folder_code_is_compiled_every_time(tmp_path):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    cached, lines = {}, {}
    for place in ("open", "own"):
        environment = {**os.environ, "SYMFRIC_CACHE_DIR": str(tmp_path / place)}
        for time_ in (1, 2):
            done = subprocess.run([sys.executable, "-c", COMPILE], capture_output=True, text=True, env=environment)
            assert done.returncode == 0, done.stderr
            cached[place, time_], lines[place, time_] = done.stdout.strip(), len(done.stderr.splitlines())
    refused = os.name == "posix"
    assert cached == {("open", 1): "False", ("open", 2): str(not refused), ("own", 1): "False", ("own", 2): "True"}
    assert lines == {("open", 1): refused, ("open", 2): refused, ("own", 1): 0, ("own", 2): 0}
    assert len(list((tmp_path / "open").iterdir())) == (not refused)


@pytest.mark.parametrize("given", [None, ""])
def test_without_a_folder_named_it_is_the_users(given, monkeypatch):
    from platformdirs import user_cache_path

    monkeypatch.delenv("SYMFRIC_CACHE_DIR", raising=False)
    if given is not None:
        monkeypatch.setenv("SYMFRIC_CACHE_DIR", given)
    assert object_cache._folder() == user_cache_path("symfric", appauthor=False)


def test_without_a_home_nothing_is_kept(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SYMFRIC_CACHE_DIR", raising=False)
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_a, **_k: Path("~/.cache/symfric"))
    object_cache.store("key", b"code")
    assert object_cache.load("key") is None
    assert list(tmp_path.iterdir()) == []


def sizes(folder) -> int:
    return sum(p.stat().st_size for p in folder.glob("*.o"))


def test_the_folder_stays_below_its_limit(folder, monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", "0.5")
    folder.mkdir(mode=0o700)
    (folder / "notes.txt").write_text("not ours")
    for k in range(200):
        object_cache.store(f"{k}", bytes(20_000))
        assert sizes(folder) <= 0.5 * 2**20 * (1 + 1 / 64) + 20_032
    kept = {p.stem for p in folder.glob("*.o")}
    assert kept == {f"{k}" for k in range(200 - len(kept), 200)}
    assert len(kept) > 20
    assert (folder / "notes.txt").exists()


def test_what_was_used_last_is_kept(folder, monkeypatch):
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", "0.5")
    day = 24 * 3600
    for k in range(10):
        object_cache.store(f"{k}", bytes(50_000))
        os.utime(folder / f"{k}.o", (time.time() - day * (20 - k),) * 2)
    assert object_cache.load("0") is not None  # used now
    object_cache.store("new", bytes(50_000))
    kept = {p.stem for p in folder.glob("*.o")}
    assert {"0", "new", "9"} <= kept
    assert not {"1", "2"} & kept


def test_new_processes_look_too(folder, monkeypatch):
    """Each stores a single object."""
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", "0.25")
    for k in range(30):
        monkeypatch.setattr(object_cache, "_stored", {})
        object_cache.store(f"{k}", bytes(20_000))
        assert sizes(folder) <= 0.25 * 2**20
    assert sizes(folder) > 0.15 * 2**20


@pytest.mark.parametrize(("given", "kept"), [("0", False), ("1e-3", False), ("1", True), ("inf", True), ("", True)])
def test_the_limit_can_be_set(folder, monkeypatch, given, kept):
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", given)
    object_cache.store("key", bytes(2000))
    assert (object_cache.load("key") is not None) is kept


@pytest.mark.parametrize("given", ["much", "-1", "nan"])
def test_a_limit_that_is_none_is_said_once(folder, monkeypatch, given, caplog):
    monkeypatch.setenv("SYMFRIC_CACHE_SIZE", given)
    for _ in range(2):
        object_cache.store("key", bytes(2000))
    assert said(caplog) == [f"SYMFRIC_CACHE_SIZE is '{given}'; it must be a number of MiB, and 512 is taken"]
    assert object_cache.load("key") is not None


@pytest.mark.parametrize("failing", ["replace", "open", "fdopen"])
def test_a_failed_write_leaves_nothing(folder, monkeypatch, failing):
    def fail(*_arguments, **_named):
        raise OSError(28, "No space left on device")

    object_cache.store("key", b"code")
    with monkeypatch.context() as patch:
        patch.setattr(f"symfric.files.os.{failing}", fail)
        object_cache.store("other", b"code")
    assert [p.name for p in folder.iterdir()] == ["key.o"]


def test_what_killed_processes_left_goes(folder):
    object_cache.store("key", b"code")
    (folder / ".old.part").write_bytes(b"half")
    (folder / ".new.part").write_bytes(b"half")
    os.utime(folder / ".old.part", (time.time() - 2 * 3600,) * 2)
    object_cache._stored.clear()
    object_cache.store("key", b"code")
    assert {p.name for p in folder.iterdir()} == {"key.o", ".new.part"}


RACE = """
import os, random, sys
from symfric.codegen import object_cache
random.seed(int(sys.argv[1]))
for _ in range(400):
    k = random.randrange(40)
    found = object_cache.load(f"{k}")
    assert found is None or found == bytes([k]) * 20_000, k
    if found is None:
        object_cache.store(f"{k}", bytes([k]) * 20_000)
"""


def test_several_processes_share_a_folder_that_is_too_small(folder):
    environment = {**os.environ, "SYMFRIC_CACHE_SIZE": "0.25"}
    processes = [
        subprocess.Popen([sys.executable, "-c", RACE, str(seed)], env=environment, stderr=subprocess.PIPE, text=True)
        for seed in range(4)
    ]
    for process in processes:
        _, errors = process.communicate(timeout=120)
        assert (process.returncode, errors) == (0, "")
    assert sizes(folder) <= 0.25 * 2**20 + 4 * 20_032
    assert not list(folder.glob("*.part"))


def test_an_object_under_the_name_of_another_is_not_loaded(folder):
    object_cache.store("one", b"code")
    object_cache.store("other", b"other code")
    (folder / "one.o").write_bytes((folder / "other.o").read_bytes())
    assert object_cache.load("one") is None
    assert object_cache.load("other") == b"other code"
    object_cache.store("one", b"code")  # as after compiling it again
    assert object_cache.load("one") == b"code"


@pytest.mark.parametrize("obstacle", ["a file", "a broken link", "a file above"])
def test_a_folder_that_cannot_be_made_keeps_nothing_and_raises_nothing(folder, monkeypatch, obstacle):
    if obstacle == "a file":
        folder.write_text("")
    elif obstacle == "a broken link":
        folder.symlink_to(folder.with_name("nowhere"))
    else:
        folder.write_text("")
        monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(folder / "deeper"))
    object_cache.store("key", b"code")
    assert object_cache.load("key") is None
    assert not folder.with_name("nowhere").exists()
