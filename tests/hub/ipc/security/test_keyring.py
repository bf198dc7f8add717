"""Keys in files: made, listed, removed; damaged and open files are refused in one sentence."""

from __future__ import annotations

import os
import string
import tempfile
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import KeyFileError, KeyNameError
from hub.ipc.roles import Principal, Role
from hub.ipc.security import key_files
from hub.ipc.security.client_keys import ClientKeys, KeyPair, read_client_keys, write_client_keys
from hub.ipc.security.keyring import Holder, Keyring, default_folder
from tests.support.cases import for_each

names = st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", fullmatch=True)
pairs = st.builds(KeyPair.new)


@pytest.fixture
def keyring(tmp_path: Path) -> Keyring:
    return Keyring(tmp_path / "keys")


def test_made_key_is_on_the_list_and_in_its_own_file_with_the_hubs_public_key(
    keyring: Keyring,
) -> None:
    keys = read_client_keys(keyring.make("alice", Role.OPERATE))
    assert keys.principal == Principal.of("alice", Role.OPERATE, keys.pair.public)
    assert keys.hub == keyring.hub_keys().public
    holder = Holder(name="alice", role=Role.OPERATE, public=keys.pair.public)
    assert keyring.holders() == (holder,)
    assert keyring.holder(keys.pair.public) == holder


def test_hub_keeps_its_keys(keyring: Keyring) -> None:
    first = keyring.hub_keys()
    assert first == keyring.hub_keys() == Keyring(keyring.folder).hub_keys()


def test_only_the_owner_can_read_what_is_written(keyring: Keyring) -> None:
    before = os.umask(0)
    try:
        keyring.make("alice", Role.OPERATE)
    finally:
        os.umask(before)
    modes = {path.stat().st_mode & 0o777 for path in keyring.folder.rglob("*") if path.is_file()}
    assert modes == {0o600}
    folders = (keyring.folder, keyring.folder / "clients")
    assert {folder.stat().st_mode & 0o777 for folder in folders} == {0o700}


def test_secrets_are_neither_on_the_list_nor_in_what_python_shows(keyring: Keyring) -> None:
    keys = read_client_keys(keyring.make("alice", Role.OPERATE))
    hub = keyring.hub_keys()
    shown = (keyring.folder / "list.toml").read_text() + repr(keys) + repr(hub)
    assert keys.pair.public in shown
    assert keys.pair.secret not in shown
    assert hub.secret not in shown


def test_name_can_be_taken_once_and_again_after_it_was_removed(keyring: Keyring) -> None:
    path = keyring.make("alice", Role.OBSERVE)
    first = read_client_keys(path)
    with pytest.raises(KeyNameError, match="rune-hub keys remove alice"):
        keyring.make("alice", Role.OPERATE)
    assert read_client_keys(path) == first
    keyring.remove("alice")
    assert not path.exists()
    assert keyring.holder(first.pair.public) is None
    assert read_client_keys(keyring.make("alice", Role.OPERATE)).pair != first.pair


def test_removing_what_is_not_there_names_the_nearest(keyring: Keyring) -> None:
    keyring.make("alice", Role.OBSERVE)
    with pytest.raises(KeyNameError, match="did you mean 'alice'"):
        keyring.remove("alise")


@pytest.mark.parametrize("name", ["", "a b", "a/b", "..", "-a", "ä", "x" * 65, 'a"b', "a\n"])
def test_name_that_is_no_file_name_is_refused(keyring: Keyring, name: str) -> None:
    with pytest.raises(KeyNameError, match="letters, digits"):
        keyring.make(name, Role.OBSERVE)
    assert not keyring.folder.exists()


def test_running_hub_sees_at_once_what_another_process_changes(keyring: Keyring) -> None:
    running = Keyring(keyring.folder)
    assert running.holders() == ()
    public = read_client_keys(keyring.make("alice", Role.OBSERVE)).pair.public
    assert running.holder(public) is not None
    keyring.remove("alice")
    assert running.holder(public) is None
    keyring.make("alice", Role.OPERATE)
    (keyring.folder / "list.toml").unlink()
    assert running.holders() == ()


def test_list_is_not_read_again_while_nothing_changes(
    keyring: Keyring, monkeypatch: pytest.MonkeyPatch
) -> None:
    public = read_client_keys(keyring.make("alice", Role.OBSERVE)).pair.public
    keyring.holder(public)
    monkeypatch.setattr(
        key_files, "read_private", lambda *_, **__: pytest.fail("it was read again")
    )
    assert keyring.holder(public) is not None


def test_keys_made_at_the_same_time_are_all_there(keyring: Keyring) -> None:
    threads = [
        threading.Thread(target=Keyring(keyring.folder).make, args=(f"key{number}", Role.OBSERVE))
        for number in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [holder.name for holder in keyring.holders()] == [f"key{number}" for number in range(8)]
    hubs = {read_client_keys(path).hub for path in (keyring.folder / "clients").iterdir()}
    assert hubs == {keyring.hub_keys().public}


@pytest.mark.parametrize("name", ["hub.toml", "list.toml", "clients/alice.toml"])
@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o666])
def test_file_that_others_can_read_or_change_is_refused(
    keyring: Keyring, name: str, mode: int
) -> None:
    keyring.make("alice", Role.OBSERVE)
    keyring.holders()
    (keyring.folder / name).chmod(mode)
    with pytest.raises(KeyFileError, match=f"chmod 600 .*{name}"):
        _read_all(keyring)


def test_folder_that_others_can_look_into_is_refused(keyring: Keyring) -> None:
    keyring.make("alice", Role.OBSERVE)
    keyring.folder.chmod(0o755)
    for use in (keyring.hub_keys, lambda: keyring.make("bob", Role.OBSERVE)):
        with pytest.raises(KeyFileError, match="chmod 700"):
            use()


@pytest.mark.parametrize("name", ["hub.toml", "list.toml", "clients/alice.toml"])
@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text[: len(text) // 2], "make a new|keys make"),
        (lambda text: text.replace('public = "', 'public = "~'), "40 characters"),
        (lambda text: text.replace("public", "publik"), "did you mean 'public'"),
        (lambda text: text + "\x00", "not TOML"),
        (lambda text: text + "\nmore = 1\n", "more"),
    ],
)
def test_damaged_file_is_refused_with_its_name_and_what_to_do(
    keyring: Keyring, name: str, damage: object, said: str
) -> None:
    keyring.make("alice", Role.OBSERVE)
    path = keyring.folder / name
    path.write_text(damage(path.read_text()))  # type: ignore[operator]
    with pytest.raises(KeyFileError, match=said) as caught:
        _read_all(keyring)
    assert name in str(caught.value)
    assert "make a new" in str(caught.value)


def test_halves_of_two_key_pairs_are_refused(keyring: Keyring) -> None:
    path = keyring.make("alice", Role.OBSERVE)
    keys = read_client_keys(path)
    path.write_text(path.read_text().replace(keys.pair.public, KeyPair.new().public))
    with pytest.raises(KeyFileError, match="no pair"):
        read_client_keys(path)


def test_one_key_under_two_names_is_refused(keyring: Keyring) -> None:
    keyring.make("alice", Role.OBSERVE)
    path = keyring.folder / "list.toml"
    path.write_text(path.read_text() + path.read_text().replace("alice", "bob"))
    with pytest.raises(KeyFileError, match="alice and bob"):
        keyring.holders()


def test_damaged_list_lets_nobody_in_until_it_is_mended(keyring: Keyring) -> None:
    public = read_client_keys(keyring.make("alice", Role.MODULE)).pair.public
    assert keyring.holder(public) is not None
    path = keyring.folder / "list.toml"
    whole = path.read_text()
    path.write_text("[")
    for _ in range(2):
        with pytest.raises(KeyFileError, match="make a new key"):
            keyring.holder(public)
    path.write_text(whole)
    assert keyring.holder(public) is not None


def test_missing_client_file_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(KeyFileError, match=r"not there.*rune-hub keys make"):
        read_client_keys(tmp_path / "nobody.toml")


@for_each("path", ["/dev/null", "/dev/zero", "/proc/self/mem", "/", "a\0b"])
def test_what_is_no_file_of_keys_is_refused(path: str) -> None:
    with pytest.raises(KeyFileError):
        read_client_keys(Path(path))


@pytest.mark.parametrize("writes", [0, 1])
def test_failed_write_leaves_what_was_there(
    keyring: Keyring, monkeypatch: pytest.MonkeyPatch, writes: int
) -> None:
    keyring.make("alice", Role.OBSERVE)
    before = sorted(keyring.folder.rglob("*"))

    room = iter(range(writes))

    def full(_: int) -> None:
        if next(room, None) is None:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(KeyFileError, match="No space left"):
        keyring.make("bob", Role.OBSERVE)
    assert sorted(keyring.folder.rglob("*")) == before
    assert [holder.name for holder in keyring.holders()] == ["alice"]


def test_folder_is_where_the_desktop_wants_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    assert default_folder() == tmp_path / "config" / "rune" / "keys"
    for unset in ("", "relative"):
        monkeypatch.setenv("XDG_CONFIG_HOME", unset)
        assert default_folder() == tmp_path / "home" / ".config" / "rune" / "keys"


@given(name=names, role=st.sampled_from(Role), pair=pairs, hub=pairs)
def test_what_is_written_is_read_back(name: str, role: Role, pair: KeyPair, hub: KeyPair) -> None:
    keys = ClientKeys(principal=Principal.of(name, role, pair.public), pair=pair, hub=hub.public)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "keys.toml"
        write_client_keys(path, keys)
        assert read_client_keys(path) == keys


@given(
    position=st.integers(0, 270),
    change=st.one_of(st.sampled_from(string.printable), st.characters(), st.text(max_size=3)),
)
def test_changed_file_is_read_as_it_was_or_refused_in_our_words(position: int, change: str) -> None:
    pair, hub = KeyPair.new(), KeyPair.new()
    principal = Principal.of("a", Role.MODULE, pair.public)
    keys = ClientKeys(principal=principal, pair=pair, hub=hub.public)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "keys.toml"
        write_client_keys(path, keys)
        text = path.read_text()
        try:
            path.write_text(text[:position] + change + text[position + 1 :])
        except UnicodeEncodeError:
            return
        said = ""
        try:
            read = read_client_keys(path)
        except KeyFileError as error:
            said = str(error)
        else:
            assert (read.role, read.pair) == (keys.role, keys.pair)
        assert pair.secret not in said


@given(st.dictionaries(names, st.sampled_from(Role), min_size=1, max_size=4))
def test_every_holder_is_found_by_its_key_and_nobody_else(wanted: dict[str, Role]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        keyring = Keyring(Path(folder))
        for name, role in wanted.items():
            keys = read_client_keys(keyring.make(name, role))
            holder = Keyring(Path(folder)).holder(keys.pair.public)
            assert holder == Holder(name=name, role=role, public=keys.pair.public)
        assert {holder.name: holder.role for holder in keyring.holders()} == wanted
        assert keyring.holder(KeyPair.new().public) is None


def _read_all(keyring: Keyring) -> None:
    keyring.hub_keys()
    keyring.holders()
    read_client_keys(keyring.folder / "clients" / "alice.toml")
