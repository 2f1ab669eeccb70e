"""Folders and zip files are read file by file, and no name in them leads outside."""

import io
import os
import stat
import struct
import subprocess
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldgrade.submissions import unpack
from fieldgrade.submissions.archive import Archive, CannotArchive
from fieldgrade.submissions.unpack import BadZip, folder_items, zip_items
from submission_files import packed, write_files


def items_of(tmp_path, content):
    file = tmp_path / "pack.zip"
    file.write_bytes(content)
    return zip_items(file)


def refusals(items):
    return {item.name: item.refused for item in items}


def link(name):
    info = zipfile.ZipInfo(name)
    info.create_system, info.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    return info


NAMES = {
    "../../bob/01.ipynb": "bob/01.ipynb",
    "/etc/passwd": "etc/passwd",
    "a/../b.ipynb": "a/b.ipynb",
    "..\\..\\b.ipynb": "b.ipynb",
    "C:\\Users\\b.ipynb": "C:/Users/b.ipynb",
    "C:b.ipynb": "C:b.ipynb",
    "./b.ipynb": "b.ipynb",
    "..": "?",
    "a//b.ipynb": "a/b.ipynb",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_path_that_leads_outside_is_refused(tmp_path, name):
    """Paths with parent folders, roots and drives are refused; the reported name is harmless."""
    assert refusals(items_of(tmp_path, packed({name: b""}))) == {NAMES[name]: unpack.LEADS_OUT}


def test_windows_paths_are_split_into_folders(tmp_path):
    """Backslashes separate folders, and a colon inside a title is not a drive."""
    found = items_of(tmp_path, packed({"work\\01.ipynb": b"1", "Homework: 1.ipynb": b"2"}))
    assert refusals(found) == {"Homework: 1.ipynb": "", "work/01.ipynb": ""}


def test_links_and_long_names_in_a_zip_file_are_refused(tmp_path):
    """The content of a link in a zip file is a path."""
    pack = packed(
        [
            (link("01.ipynb"), b"/etc/passwd"),
            ("n" * 60_000, b""),
            ("d/" * 5000, b""),
            ("d/" * 5000 + "x", b""),
        ]
    )
    assert refusals(items_of(tmp_path, pack)) == {
        "01.ipynb": "it is a link",
        "n" * 255: "its name is too long",
        "d/" * 99 + "x": "its name is too long",
    }


def encrypted(pack):
    """Set the encryption flag on every member."""
    data = bytearray(pack)
    for magic, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = data.find(magic)
        while at >= 0:
            data[at + offset] |= 1
            at = data.find(magic, at + 4)
    return bytes(data)


def test_encrypted_files_are_refused(tmp_path):
    """No password is requested."""
    pack = encrypted(packed({"01.ipynb": b"{}"}))
    assert refusals(items_of(tmp_path, pack)) == {"01.ipynb": "it is encrypted"}


def test_files_that_are_not_the_students_work_are_skipped(tmp_path):
    """These are system files, caches, hidden files, and the checks that were handed out."""
    junk = [
        "__MACOSX/._01.ipynb",
        "._01.ipynb",
        ".DS_Store",
        "Thumbs.db",
        "student.txt",
        ".ipynb_checkpoints/01-checkpoint.ipynb",
        "fieldcheck/calls.py",
        "venv/lib/x.py",
        "a/__pycache__/x.pyc",
    ]
    files = dict.fromkeys([*junk, "a/01.ipynb"], b"x")
    assert [item.name for item in items_of(tmp_path, packed(files))] == ["a/01.ipynb"]
    assert [i.name for i in folder_items(write_files(tmp_path / "class", files))] == ["a/01.ipynb"]


HIDDEN = [".ada/01.ipynb", "ada/.work/01.ipynb", ".ada.zip", "...ipynb"]


@pytest.mark.parametrize("name", HIDDEN)
def test_a_name_that_begins_with_a_dot_is_read(tmp_path, name):
    """A student's name may begin with a dot, and so may a student's folder."""
    assert [item.name for item in items_of(tmp_path, packed({name: b""}))] == [name]
    folder = write_files(tmp_path / "class", {name: b""})
    assert [item.name for item in folder_items(folder)] == [name]


def test_an_item_has_the_bytes_of_its_member(tmp_path):
    """This also holds for two members of the same name."""
    with pytest.warns(UserWarning, match="Duplicate name"):
        pack = packed([("01.ipynb", b"first"), ("01.ipynb", b"second")])
    assert [item.open().read() for item in items_of(tmp_path, pack)] == [b"first", b"second"]


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x05\x06" + b"\0" * 17])
def test_a_file_that_is_not_a_zip_file_is_refused(tmp_path, content):
    with pytest.raises(BadZip, match="the zip file is damaged"):
        items_of(tmp_path, content)


@pytest.mark.slow
@given(st.data())
def test_a_damaged_zip_file_is_refused_or_read(tmp_path_factory, data):
    """Any bytes may be changed; no other error is raised."""
    pack = bytearray(packed({"a/01.ipynb": b"{}" * 50, "b.txt": b"text"}))
    for at in data.draw(st.lists(st.integers(0, len(pack) - 1), max_size=6)):
        pack[at] = data.draw(st.integers(0, 255))
    folder = tmp_path_factory.mktemp("zip")
    archive = Archive(folder / "archive")
    try:
        found = items_of(folder, bytes(pack))
    except BadZip:
        return
    for item in found:
        try:
            stream = item.open()
        except Exception:  # the intake turns it into a problem of the file
            continue
        with stream:
            try:
                archive.put(stream, 1000)
            except CannotArchive as error:
                assert str(error)  # noqa: PT017


def test_a_zip_file_with_too_many_members_is_refused(tmp_path, monkeypatch):
    """Members are counted before a list of them is made in memory."""
    pack = packed({f"{k}.txt": b"" for k in range(30)})
    monkeypatch.setattr(unpack, "MOST_MEMBERS", 29)
    monkeypatch.setattr(unpack.zipfile, "ZipFile", None)
    with pytest.raises(BadZip, match="holds more than 29 files and folders"):
        items_of(tmp_path, pack)


MANY = {
    "files": {f"{k}.txt": b"" for k in range(21_000)},
    "folders": {f"{k}/": b"" for k in range(21_000)},
}


@pytest.mark.slow
@pytest.mark.parametrize("files", MANY.values(), ids=MANY)
def test_the_reason_for_refusing_a_zip_file_with_many_members_is_true(tmp_path, files):
    with pytest.raises(BadZip, match="holds more than 20000 files and folders"):
        items_of(tmp_path, packed(files))


def test_the_members_of_an_inner_zip_file_do_not_count(tmp_path, monkeypatch):
    """An inner zip file is stored as it is, with a directory of its own."""
    monkeypatch.setattr(unpack, "MOST_MEMBERS", 29)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as pack:
        pack.writestr("in.zip", packed({f"{k}.txt": b"" for k in range(29)}))
        pack.writestr("01.ipynb", b"{}")
    assert len(items_of(tmp_path, stream.getvalue())) == 2


def test_a_zip_file_with_too_large_a_declared_size_is_refused(tmp_path, monkeypatch):
    """The declared size is trusted if it exceeds the limit."""
    monkeypatch.setattr(unpack, "MOST_UNPACKED", 2_000_000)
    with pytest.raises(BadZip, match="more than 1 MiB"):
        items_of(tmp_path, packed({"a": b"0" * 1_500_000, "b": b"0" * 1_500_000}))


def test_a_member_larger_than_its_declared_size_is_refused(tmp_path):
    """No more than the declared size is unpacked."""
    pack = bytearray(packed({"a": b"0" * 100_000}))
    at = pack.find(b"PK\x01\x02")
    pack[at + 24 : at + 28] = struct.pack("<I", 10)
    (item,) = items_of(tmp_path, bytes(pack))
    with pytest.raises(CannotArchive, match="it cannot be read"):
        Archive(tmp_path / "archive").put(item.open(), 1 << 20)


def test_links_pipes_and_devices_in_a_folder_are_refused(tmp_path):
    """None of them is opened, and no link is followed."""
    folder = write_files(tmp_path / "class", {"ada/01.ipynb": b"{}"})
    (folder / "bob.ipynb").symlink_to("/etc/passwd")
    (folder / "cid").symlink_to(tmp_path)
    os.mkfifo(folder / "dan.ipynb")
    assert refusals(folder_items(folder)) == {
        "ada/01.ipynb": "",
        "bob.ipynb": "it is a link",
        "cid": "it is a link",
        "dan.ipynb": "it is not a regular file",
    }


@pytest.mark.slow
def test_deeply_nested_folders_are_read(tmp_path):
    """They are nested deeper than Python's recursion limit."""
    folder = tmp_path / "class"
    folder.mkdir()
    start = os.open(folder, os.O_RDONLY)
    at = start
    for _ in range(1500):
        os.mkdir("d", dir_fd=at)
        inner = os.open("d", os.O_RDONLY, dir_fd=at)
        if at != start:
            os.close(at)
        at = inner
    os.close(at)
    os.close(start)
    (folder / "01.ipynb").write_bytes(b"{}")
    try:
        assert [item.name for item in folder_items(folder)] == ["01.ipynb"]
    finally:
        subprocess.run(
            ["rm", "-rf", folder], check=True
        )  # pytest's own removal would recurse too deep


def test_an_unreadable_folder_is_reported(tmp_path, monkeypatch):
    """The other folders are read."""
    folder = write_files(tmp_path / "class", {"ada/01.ipynb": b"{}", "bob/01.ipynb": b"{}"})
    whole = Path.iterdir

    def iterdir(path):
        if path.name == "bob":
            raise PermissionError(13, "Permission denied")
        return whole(path)

    monkeypatch.setattr(Path, "iterdir", iterdir)
    assert refusals(folder_items(folder)) == {
        "ada/01.ipynb": "",
        "bob": "it cannot be read (Permission denied)",
    }


def test_unprintable_file_names_are_reported_as_text(tmp_path):
    """Names may contain control characters, and bytes that are not valid UTF-8."""
    (tmp_path / "a\x1b[2J\nb.ipynb").touch()
    assert [item.name for item in folder_items(tmp_path)] == [r"a\x1b[2J\nb.ipynb"]
    assert unpack._printable(os.fsdecode(b"\xff.ipynb")).encode() == b"\\udcff.ipynb"


def test_times_are_given_in_utc(tmp_path):
    """Times in zip files are local times; impossible times are left empty."""
    (tmp_path / "01.ipynb").touch()
    os.utime(tmp_path / "01.ipynb", (0, 0))
    assert folder_items(tmp_path)[0].time == "1970-01-01T00:00:00+00:00"
    info = zipfile.ZipInfo("01.ipynb", date_time=(2026, 11, 20, 12, 0, 0))
    never = zipfile.ZipInfo("02.ipynb", date_time=(1980, 0, 0, 0, 0, 0))
    first, second = items_of(tmp_path, packed([(info, b""), (never, b"")]))
    assert first.time.endswith("+00:00")
    assert (first.by, second.time) == ("zip", "")


def test_the_archive_keeps_the_received_bytes(tmp_path):
    """A file is stored once, under its digest, and is read-only."""
    archive = Archive(tmp_path / "received")
    digests = {archive.put(io.BytesIO(b"content"), 100) for _ in range(2)}
    (digest,) = digests
    file = archive.path(digest)
    assert file.read_bytes() == archive.read(digest, 100) == b"content"
    assert stat.S_IMODE(file.stat().st_mode) == 0o444
    assert [p for p in (tmp_path / "received").rglob("*") if p.is_file()] == [file]
    assert archive.read(digest, 3) == b"cont"


class Failing(io.BytesIO):
    def read(self, _size=-1):
        raise EOFError("compressed file ended")


@pytest.mark.parametrize(
    ("stream", "sentence"),
    [(io.BytesIO(b"0" * (2 << 20)), "more than 1 MiB"), (Failing(), "cannot be read .compressed")],
)
def test_a_failed_archiving_leaves_no_file(tmp_path, stream, sentence):
    """The content is too large, or the zip file is damaged."""
    with pytest.raises(CannotArchive, match=sentence):
        Archive(tmp_path).put(stream, 1 << 20)
    assert list(tmp_path.iterdir()) == []


def test_an_error_of_the_archive_folder_is_raised(tmp_path):
    """A full disk stops the grader and is not recorded as the fault of a student."""
    (tmp_path / "received").touch()
    with pytest.raises(FileExistsError):
        Archive(tmp_path / "received").put(io.BytesIO(b"x"), 10)
