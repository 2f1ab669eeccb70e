"""Intake of submissions: every file finds its student and notebook, and is graded or reported."""

import hashlib
import io
import os
import resource
import zipfile
import zlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_unpack import encrypted, link

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions import collection, helper_files
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.intake import Intake
from submission_files import ANSWER, FUNCTIONS, notebook, packed, write_files

RIGHT, OTHER = notebook(ANSWER), notebook("x = 2", ANSWER)
SECOND = notebook("def weights(x): return x\ndef field(x): return x")
ADA = Student("s1", "Ada Lovelace", "ada@x.org", "alove", "12", "77", "", "512")
BOB = Student("s2", "Bob Byte", "bob@x.org", "bbyte", "13", "78", "", "513")
ROSTER = {"s1": ADA, "s2": BOB}


def intake(tmp_path, **options):
    return Intake(Archive(tmp_path / "received"), FUNCTIONS, **options)


def take(tmp_path, files, **options):
    """The submissions found among files that are written to a folder."""
    return intake(tmp_path, **options).take(write_files(tmp_path / "class", files))


def graded_files(handed):
    """The name of the graded file for each student and notebook."""
    return {(h.student, h.notebook): h.name for h in handed if h.notebook}


CANVAS = {
    "lovelaceada_12_345_01.ipynb": RIGHT,
    "bytebob_LATE_13_346_01-2.ipynb": OTHER,
}
MOODLE_FLAT = {
    "Ada Lovelace_512_assignsubmission_file_01.ipynb": RIGHT,
    "Bob Byte_513_assignsubmission_file_my work (1).ipynb": OTHER,
}
MOODLE = {
    "Ada Lovelace_512_assignsubmission_file_/01.ipynb": RIGHT,
    "Ada Lovelace_512_assignsubmission_onlinetext_/onlinetext.html": b"<p>Done</p>",
    "Bob Byte_513_assignsubmission_file/sub/01.ipynb": OTHER,
}
METADATA = b"""---
submission_901:
  :submitters:
  - :name: Ada Lovelace
    :sid: '77'
    :email: ada@x.org
  :created_at: 2026-11-20 12:00:00.123456789 Z
  :score: 0.0
  :results:
    tests:
    - :name: Bob Byte
      :email: bob@x.org
  :history:
  - :id: 1
    :created_at: 2026-01-01 12:00:00 Z
submission_902:
  :submitters:
  - :name: Bob Byte
    :sid: s2
    :email:
  :created_at: 2026-11-20 23:30:00 -07:00
"""
GRADESCOPE = {
    "assignment_1_export/submission_metadata.yml": METADATA,
    "assignment_1_export/submission_901/01.ipynb": RIGHT,
    "assignment_1_export/submission_902/01.ipynb": OTHER,
}
PLAIN = {"s1/01.ipynb": RIGHT, "s2/deep/er/01 (3).ipynb": OTHER}
LOOSE = {"s1_01.ipynb": RIGHT, "Bob Byte 01 (2).ipynb": OTHER}
ZIPS = {"s1.zip": packed({"work/01.ipynb": RIGHT}), "bbyte.zip": packed({"01.ipynb": OTHER})}
FORMS = {
    "Canvas": CANVAS,
    "Moodle, flat": MOODLE_FLAT,
    "Moodle": MOODLE,
    "Gradescope": GRADESCOPE,
    "plain folders": PLAIN,
    "loose files": LOOSE,
    "zip files": ZIPS,
}


def as_zip(files):
    """One zip file, as platforms deliver a class."""
    return packed(dict(sorted(files.items())))


@pytest.mark.parametrize("files", FORMS.values(), ids=FORMS)
@pytest.mark.parametrize("way", ["folder", "zip", "zip in a folder", "zip with a folder"])
def test_every_layout_of_a_class_is_read(tmp_path, files, way):
    """In folders or zip files, each file is assigned to its student."""
    place = tmp_path / "class"
    if way == "folder":
        write_files(place, files)
    elif way == "zip":
        place.write_bytes(as_zip(files))
    elif way == "zip with a folder":
        place.write_bytes(as_zip({f"hand-ins/{n}": c for n, c in files.items()}))
        if files in (LOOSE, ZIPS):  # a zip file with one folder would belong to one student
            place.write_bytes(as_zip(files))
    else:
        write_files(place, {"submissions.zip": as_zip(files)})
        if files in (LOOSE, ZIPS):  # a zip file in the class folder could belong to one student
            place = place / "submissions.zip"
    handed = intake(tmp_path, roster=ROSTER).take(place)
    content = {h.student: h.submission(Archive(tmp_path / "received")).content for h in handed}
    assert content == {"s1": RIGHT, "s2": OTHER}
    assert [h.notebook for h in handed] == ["01", "01"]
    assert not [note for h in handed for note in h.notes if "roster" in note]


def test_late_marks_and_times_of_platforms_are_recorded(tmp_path):
    """Canvas marks late files; Gradescope gives the time of each submission, recorded in UTC."""
    canvas = take(tmp_path / "canvas", CANVAS, roster=ROSTER)
    assert [h.late_mark for h in canvas] == [False, True]
    scope = take(tmp_path / "scope", GRADESCOPE, roster=ROSTER)
    assert [(h.received, h.received_by) for h in scope] == [
        ("2026-11-20T12:00:00+00:00", "platform"),
        ("2026-11-21T06:30:00+00:00", "platform"),
    ]


def test_several_bulk_downloads_are_read_together(tmp_path):
    """Platforms make one download per notebook; each one identifies the owners of its folders."""
    second = METADATA.replace(b"submission_90", b"submission_80")
    files = {
        "one.zip": as_zip(GRADESCOPE),
        "two.zip": as_zip({"submission_metadata.yml": second, "submission_802/b.ipynb": SECOND}),
    }
    handed = take(tmp_path, files, roster=ROSTER)
    assert [(h.student, h.notebook) for h in handed] == [("s1", "01"), ("s2", "01"), ("s2", "02")]
    folders = {f"hw{k}/{name}": content for k in (1, 2) for name, content in CANVAS.items()}
    handed = take(tmp_path / "folders", folders, roster=ROSTER)
    assert [(h.student, h.notebook) for h in handed] == [("s1", "01"), ("s2", "01")]


def test_an_unreadable_list_of_owners_is_reported(tmp_path):
    """The submissions are graded under the names of their folders."""
    place = tmp_path / "class.zip"
    files = {"submission_metadata.yml": METADATA, "submission_901/01.ipynb": RIGHT}
    place.write_bytes(encrypted(packed(files)))
    taking = intake(tmp_path)
    (only,) = taking.take(place)
    assert (only.student, only.problem) == ("submission_901", "it is encrypted")
    assert taking.strays == ["submission_metadata.yml: it is encrypted"]


def test_a_group_submission_of_gradescope_counts_for_each_member(tmp_path):
    """There is one file and one record for each member."""
    bob = b"  - :name: Bob Byte\n    :sid: '78'\n  :created_at"
    group = METADATA.replace(b"  :created_at", bob, 1)
    files = {"submission_metadata.yml": group, "submission_901/01.ipynb": RIGHT}
    handed = take(tmp_path, files, roster=ROSTER)
    assert [h.student for h in handed] == ["s1", "s2"]
    assert len({h.digest for h in handed}) == 1


ATTACKS = {
    "a zip file with names of Canvas": ("s1.zip", packed({"bytebob_13_346_01.ipynb": RIGHT})),
    "a zip file with an export of Gradescope": (
        "s1.zip",
        packed({"submission_metadata.yml": METADATA, "submission_902/01.ipynb": RIGHT}),
    ),
    "a folder with an export of Gradescope": ("s1/submission_902/01.ipynb", RIGHT),
    "names of Canvas in a folder": ("s1/bytebob_13_346_01.ipynb", RIGHT),
    "a name of Moodle in a name of Moodle": (
        "Ada Lovelace_512_assignsubmission_file_Bob Byte_513_assignsubmission_file_01.ipynb",
        RIGHT,
    ),
    "a name of Canvas in a name of Canvas": ("lovelaceada_12_345_bytebob_13_346_01.ipynb", RIGHT),
    "a zip file of the class": ("s1.zip", packed({"s1/01.ipynb": RIGHT, "s2/01.ipynb": RIGHT})),
    "a way out of a zip file": ("s1.zip", packed({"01.ipynb": RIGHT, "../s2/01.ipynb": RIGHT})),
}


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=ATTACKS)
@pytest.mark.parametrize("beside", [{"s2/01.ipynb": OTHER}, {"s2.ipynb": OTHER}, {}])
def test_a_student_cannot_submit_for_another_student(tmp_path, attack, beside):
    """Whatever a student names the files, they belong to this student."""
    name, content = attack
    files = {name: content} | beside
    if name == "s1/submission_902/01.ipynb":
        files["s1/submission_metadata.yml"] = METADATA
    handed = take(tmp_path, files, roster=ROSTER)
    theirs = [h for h in handed if h.student == "s2"]
    assert {h.student for h in handed} == ({"s1", "s2"} if beside else {"s1"})
    assert [(h.name, h.notes) for h in theirs] == [
        (name.rpartition("s2/")[2], ()) for name in beside
    ]


def test_paths_that_lead_out_of_a_bulk_download_are_reported(tmp_path):
    """Other submissions are graded."""
    place = tmp_path / "class.zip"
    place.write_bytes(
        as_zip({"../s2/01.ipynb": RIGHT, "/s2/01.ipynb": RIGHT, "s1/01.ipynb": OTHER})
    )
    taking = intake(tmp_path, roster=ROSTER)
    assert graded_files(taking.take(place)) == {("s1", "01"): "01.ipynb"}
    assert taking.strays == ["s2/01.ipynb: its name leads out of the folder"] * 2


def test_the_latest_attempt_counts_and_earlier_ones_are_reported(tmp_path):
    """If the times are equal, the number at the end of the file name decides."""
    files = {
        f"s1/{name}.ipynb": notebook(f"k = {k}", ANSWER)
        for k, name in enumerate(["01", "01 (10)", "01 (9)", "01-2"])
    }
    handed = take(tmp_path, files)
    assert graded_files(handed) == {("s1", "01"): "01 (10).ipynb"}
    assert handed[0].notes == (
        "01.ipynb is not graded: 01-2.ipynb came later",
        "01-2.ipynb is not graded: 01 (9).ipynb came later",
        "01 (9).ipynb is not graded: 01 (10).ipynb came later",
    )


def test_the_time_of_an_attempt_has_precedence_over_its_number(tmp_path):
    folder = write_files(tmp_path / "class", {"s1/01 (2).ipynb": RIGHT, "s1/b.ipynb": OTHER})
    os.utime(folder / "s1/01 (2).ipynb", (100, 100))
    os.utime(folder / "s1/b.ipynb", (200, 200))
    assert graded_files(intake(tmp_path).take(folder)) == {("s1", "01"): "b.ipynb"}


def test_a_notebook_has_precedence_over_a_script(tmp_path):
    """A module that was submitted with the notebook does not replace it."""
    handed = take(tmp_path, {"s1/a.ipynb": RIGHT, "s1/z.py": ANSWER.encode()})
    assert graded_files(handed) == {("s1", "01"): "a.ipynb"}
    assert handed[0].notes == ("z.py is not graded: a.ipynb is the notebook",)


def test_two_notebooks_of_a_student_are_both_graded(tmp_path):
    """Files that are not notebooks are reported with the first of them; both can use them."""
    files = {"s1/a.ipynb": RIGHT, "s1/b.ipynb": SECOND, "s1/report.pdf": b"%PDF", "s1/x.py": b"1"}
    handed = take(tmp_path, files)
    assert graded_files(handed) == {("s1", "01"): "a.ipynb", ("s1", "02"): "b.ipynb"}
    assert handed[0].notes == ("report.pdf is not graded: it is not a notebook",)
    assert [[path for path, _ in file.helpers] for file in handed] == [["report.pdf", "x.py"]] * 2


def test_a_damaged_notebook_beside_an_intact_one_is_reported(tmp_path):
    """It was meant to be graded, so it has a record of its own."""
    handed = take(tmp_path, {"s1/a.ipynb": RIGHT, "s1/b.ipynb": SECOND[:50]})
    assert [(h.notebook, h.problem) for h in handed] == [
        ("01", ""),
        ("", "the file is not a complete notebook: its JSON is broken"),
    ]


BROKEN = {
    "an empty file": (b"", "the file is empty"),
    "a cut file": (RIGHT[:30], "JSON is broken"),
    "bytes": (bytes(range(256)), "the file is not text"),
    "a list": (b"[]", "it has no cells"),
}


@pytest.mark.parametrize(("content", "problem"), BROKEN.values(), ids=BROKEN)
def test_an_unreadable_submission_does_not_affect_others(tmp_path, content, problem):
    """The record of the student states the problem."""
    first, second = take(tmp_path, {"s1/01.ipynb": content, "s2/01.ipynb": RIGHT})
    assert (first.student, first.notebook) == ("s1", "")
    assert problem in first.problem
    assert graded_files([second]) == {("s2", "01"): "01.ipynb"}


def test_a_student_without_any_notebook_has_a_record(tmp_path):
    """Every student who submitted a file has a record."""
    (only,) = take(tmp_path, {"s1/letter.docx": b"PK", "s1/photo.png": b"\x89PNG"})
    assert (only.student, only.problem) == ("s1", "it is not a notebook")
    assert len(only.notes) == 1


def bomb(members=20, size=40 << 20):
    """A zip file whose members are a thousand times larger when unpacked."""
    return packed({f"{k}.ipynb": b"0" * size for k in range(members)})


def nested(times=6):
    """A zip file in a zip file, several levels deep."""
    pack = packed({"01.ipynb": RIGHT})
    for _ in range(times):
        pack = packed({"in.zip": pack})
    return pack


PACKS = {
    "no zip file": (lambda: b"PK", "the zip file is damaged"),
    "encrypted": (lambda: encrypted(packed({"01.ipynb": RIGHT})), "it is encrypted"),
    "a link": (lambda: packed([(link("01.ipynb"), b"/etc/passwd")]), "it is a link"),
    "a bomb": (bomb, "more than"),
    "empty": (lambda: packed({}), "there is nothing in it"),
    "too deep": (nested, "it is a zip file in too many others"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("pack", "problem"), PACKS.values(), ids=PACKS)
def test_a_zip_file_that_cannot_be_unpacked_is_reported(tmp_path, pack, problem):
    """The reason is recorded, and the bytes are archived."""
    pack = pack()
    handed = take(tmp_path, {"s1.zip": pack, "s2/01.ipynb": RIGHT})
    assert problem in handed[0].problem
    assert {h.student for h in handed} == {"s1", "s2"}
    assert graded_files(handed) == {("s2", "01"): "01.ipynb"}
    digest = hashlib.sha256(pack).hexdigest()
    assert Archive(tmp_path / "received").path(digest).read_bytes() == pack


def test_the_unpacked_size_of_a_students_zip_files_is_limited(tmp_path, monkeypatch):
    """The limit is for all zip files of a student together."""
    monkeypatch.setattr(collection, "MOST_UNPACKED", 3 << 20)
    inner = packed({f"{k}.txt": bytes([k]) * (1 << 20) for k in range(20)})
    take(tmp_path, {"s1.zip": packed({"a.zip": inner, "b.zip": inner, "01.ipynb": RIGHT})})
    kept = sum(f.stat().st_size for f in (tmp_path / "received").rglob("*") if f.is_file())
    assert kept < 4 << 20


def test_a_nested_zip_file_is_unpacked(tmp_path):
    inner = packed({"work/01.ipynb": RIGHT})
    handed = take(tmp_path, {"s1.zip": packed({"more.zip": inner}), "s2/01.ipynb": RIGHT})
    assert graded_files(handed)["s1", "01"] == "s1.zip/more.zip/work/01.ipynb"


@pytest.mark.slow
def test_among_thousands_of_files_notebooks_have_precedence(tmp_path):
    """The number of files that are left out is reported."""
    files = {f"data/{k:04}.csv": b"%d" % k for k in range(3000)} | {"z/01.ipynb": RIGHT}
    (only,) = take(tmp_path, {"s1/all.zip": packed(files)})
    assert only.notebook == "01"
    left_out = 3001 - (collection.MOST_FILES - 1)
    notes = f"all.zip/… is not graded: there are too many files: {left_out} are left out"
    assert notes in only.notes


@pytest.mark.slow
def test_a_class_with_thousands_of_files_is_read(tmp_path):
    """Each student has a record, and reading takes seconds."""
    roster = {f"s{k}": Student(f"s{k}", f"First{k} Last{k}") for k in range(1000)}
    place = tmp_path / "class.zip"
    place.write_bytes(
        as_zip(
            {
                f"last{k}first{k}_{k}_{k}_{n}.ipynb": RIGHT if n == "01" else SECOND
                for k in range(1000)
                for n in ("01", "02")
            }
        )
    )
    handed = intake(tmp_path, roster=roster).take(place)
    assert {*graded_files(handed)} == {(s, n) for s in roster for n in ("01", "02")}


def test_more_zip_files_than_open_files_are_allowed_are_read(tmp_path):
    """The limit of open files is lowered for the test."""
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    count = 60
    resource.setrlimit(resource.RLIMIT_NOFILE, (len([*Path("/dev/fd").iterdir()]) + 40, _))
    try:
        pack = packed({"01.ipynb": RIGHT})
        handed = take(tmp_path, {f"s{k}.zip": pack for k in range(count)})
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, _))
    assert len(graded_files(handed)) == count


def test_identical_files_of_two_students_are_both_graded(tmp_path):
    """The archive contains the file once."""
    handed = take(tmp_path, {"s1/01.ipynb": RIGHT, "s2/01.ipynb": RIGHT})
    assert graded_files(handed) == {("s1", "01"): "01.ipynb", ("s2", "01"): "01.ipynb"}
    assert len([f for f in (tmp_path / "received").rglob("*") if f.is_file()]) == 1


def test_identical_files_of_a_student_count_once(tmp_path):
    """A copy is not another attempt."""
    (only,) = take(tmp_path, {"s1/01.ipynb": RIGHT, "s1/copy.ipynb": RIGHT})
    assert only.notes == ()


def test_students_missing_from_the_roster_are_graded_and_reported(tmp_path):
    """The student may have joined late, or the name may be misspelled."""
    first, _ = take(tmp_path, {"eve/01.ipynb": RIGHT, "s1/01.ipynb": RIGHT}, roster=ROSTER)
    assert (first.student, first.notes) == ("eve", ("eve is not on the roster",))


def test_unknown_students_of_the_same_name_are_kept_apart(tmp_path):
    """Without a roster, the platform's numbers distinguish them."""
    handed = take(tmp_path, {"leeann_1_10_01.ipynb": RIGHT, "leeann_2_11_01.ipynb": OTHER})
    assert [h.student for h in handed] == ["leeann (1)", "leeann (2)"]


def test_a_table_of_times_has_precedence_over_file_times(tmp_path):
    """The record names the source of its time."""
    times = {("s1", "01"): "2026-11-20T12:00:00+01:00"}
    (only,) = take(tmp_path, {"s1/01.ipynb": RIGHT}, times=times)
    assert (only.received, only.received_by) == (times["s1", "01"], "list")


def test_a_file_in_a_students_zip_file_has_the_time_of_the_zip_file(tmp_path):
    """Times inside the zip file come from the clock of the student."""
    early = zipfile.ZipInfo("01.ipynb", date_time=(1999, 1, 1, 0, 0, 0))
    folder = write_files(tmp_path / "class", {"s1/all.zip": packed([(early, RIGHT)])})
    os.utime(folder / "s1/all.zip", (1_000_000_000, 1_000_000_000))
    (only,) = intake(tmp_path).take(folder)
    assert only.received == "2001-09-09T01:46:40+00:00"


def test_received_files_are_not_changed(tmp_path):
    """Bytes and names stay the same, and no file is added."""
    files = PLAIN | ZIPS | CANVAS
    folder = write_files(tmp_path / "class", files)
    intake(tmp_path).take(folder)
    there = [path for path in folder.rglob("*") if path.is_file()]
    assert {str(path.relative_to(folder)): path.read_bytes() for path in there} == files


def test_reading_a_class_twice_gives_the_same_submissions(tmp_path):
    """The order is the same, and nothing is archived again."""
    folder = write_files(tmp_path / "class", PLAIN | ZIPS | CANVAS | {"s9/x.ipynb": b""})
    first, second = (intake(tmp_path, roster=ROSTER).take(folder) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("files", [{}, {".hidden": b""}, {"student.txt": b"s1"}])
def test_an_empty_class_is_refused(tmp_path, files):
    (tmp_path / "class").mkdir()
    with pytest.raises(ValueError, match="there is no submission"):
        take(tmp_path, files)


def test_a_notebook_in_place_of_a_class_is_refused(tmp_path):
    with pytest.raises(ValueError, match="the zip file is damaged"):
        intake(tmp_path).take(write_files(tmp_path, {"a.ipynb": RIGHT}) / "a.ipynb")


def test_helper_files_come_with_the_notebook_of_the_same_student(tmp_path):
    """Their paths are those from its folder; they are not reported as files without an answer."""
    ours = {"hw/01.ipynb": RIGHT, "hw/lib/bases.py": b"B = 1", "helper-1.py": b"H = 1"}
    files = {
        "s1/all.zip": packed(ours),
        "s1/notes.txt": b"x",
        "s2/01.ipynb": notebook(ANSWER, "import helper"),
        "s3/01.ipynb": RIGHT,
        "s3/mine.py": ANSWER.encode(),
        "s3/large.py": b"#" * (helper_files.MOST_BYTES + 1),
    }
    one, two, three = take(tmp_path, files)
    archive = Archive(tmp_path / "received")

    def helpers(file):
        return dict(file.submission(archive).files())

    assert helpers(one) == {"helper.py": b"H = 1", "lib/bases.py": b"B = 1", "notes.txt": b"x"}
    assert [note.partition(" ")[0] for note in one.notes] == ["notes.txt"]
    assert helpers(two) == {}
    assert helpers(three) == {"mine.py": ANSWER.encode()}
    assert three.notes[-1] == helper_files.TOO_LARGE.format("large.py")
    digests = {file.submission(archive).code_digest for file in (one, three)}
    assert len(digests) == 2


def test_a_script_that_a_notebook_imports_is_not_graded_by_itself(tmp_path):
    """It may define functions that another notebook asks for; a script of its own is graded."""
    mine = b"def gradient(c, x):\n    return c\n"
    second = notebook("from mine import gradient", "def weights(p, x): return p")
    files = {"s1/02.ipynb": second, "s1/mine.py": mine, "s2/02.ipynb": second, "s2/own.py": mine}
    handed = take(tmp_path, files)
    assert graded_files(handed) == {
        ("s1", "02"): "02.ipynb",
        ("s2", "01"): "own.py",
        ("s2", "02"): "02.ipynb",
    }
    assert [path for path, _ in handed[0].helpers] == ["mine.py"]


def test_data_files_come_with_the_notebook_that_names_them(tmp_path):
    """Others are there too, and are reported as files that are not graded."""
    reads = notebook(ANSWER, "np.loadtxt('in/wind.csv'); open('large.bin'); open('a.txt')")
    files = {
        "s1/hw/01.ipynb": reads,
        "s1/hw/in/wind.csv": b"1",
        "s1/large.bin": bytes(helper_files.MOST_BYTES - 2),
        "s1/a-1.txt": b"2",
        "s1/photo.png": b"3",
        "s1/hw/02.ipynb": b"{}",
        "s2/01.ipynb": reads,
    }
    one, *_, two = take(tmp_path, files)
    paths = {"in/wind.csv", "wind.csv", "a-1.txt", "a.txt", "photo.png"}
    assert {path for path, _ in one.helpers} == paths
    assert one.notes == (
        helper_files.TOO_LARGE.format("large.bin"),
        "photo.png is not graded: it is not a notebook",
    )
    assert two.helpers == ()


def test_the_number_of_helper_files_is_limited_before_they_are_read(tmp_path):
    """Python files and small files come first; other names of a file have no precedence."""
    reads = notebook(ANSWER, "open(f'{k}.csv')")
    files = {f"s1/d/{k:03}.csv": b"x" * k for k in range(helper_files.MOST_FILES + 9)}
    (one,) = take(tmp_path, {**files, "s1/01.ipynb": reads, "s1/h.py": b"#" * 999})
    chosen = {path for path, _ in one.helpers}
    assert chosen == {"h.py", *(f"d/{k:03}.csv" for k in range(helper_files.MOST_FILES - 1))}


@pytest.mark.parametrize("name", ["../up.py", "a/../../up.py", "/up.py", "x y.py", "1.py"])
def test_a_helper_file_has_a_path_that_can_be_imported(name):
    """No path leads out of the folder of the notebook."""
    assert helper_files.paths_beside(name, "01.ipynb") in ([], ["up.py"])


@pytest.mark.parametrize(
    "name", ["../up.csv", "a/../../up.csv", "a/\0.csv", "a/\n", "x" * 300, "b.IPYNB", "c.zip", ""]
)
def test_a_data_file_has_a_path_beside_the_notebook(name):
    """No path leads out of its folder, and no name is longer than a file system permits."""
    assert helper_files.paths_beside(name, "01.ipynb") == []


def test_paths_of_many_folders_are_cut_to_the_name():
    assert helper_files.paths_beside("a/" * 9 + "x.csv", "01.ipynb") == ["x.csv"]
    assert helper_files.paths_beside("/up.csv", "01.ipynb") == ["up.csv"]


names = st.text(st.characters(exclude_characters="/\0", codec="utf-8"), min_size=1, max_size=30)
kinds = st.sampled_from([".ipynb", ".py", ".zip", "", "/01.ipynb", "/submission_metadata.yml"])
contents = (
    st.binary(max_size=200)
    | st.sampled_from([RIGHT, RIGHT[:40], METADATA, packed({"../a.ipynb": RIGHT}), as_zip(CANVAS)])
    | st.binary(max_size=60).map(lambda junk: packed({"01.ipynb": RIGHT})[:-30] + junk)
    | st.binary(max_size=60).map(lambda junk: b'{"cells": [' + zlib.compress(junk))
)


@pytest.mark.slow
@given(st.dictionaries(st.tuples(names, kinds).map("".join), contents, min_size=1, max_size=5))
def test_arbitrary_files_do_not_affect_other_submissions(tmp_path_factory, files):
    """Whatever files a bulk download contains, an honest student's work is graded."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as pack:
        for name, content in files.items():
            pack.writestr(name, content)
        pack.writestr("s1/01.ipynb", RIGHT)
        pack.writestr("s2/x/01.ipynb", OTHER)
    folder = tmp_path_factory.mktemp("any")
    (folder / "class.zip").write_bytes(stream.getvalue())
    handed = Intake(Archive(folder / "received"), FUNCTIONS, ROSTER).take(folder / "class.zip")
    assert all(h.notebook in FUNCTIONS or h.problem for h in handed)
    assert {("s1", "01"), ("s2", "01")} <= set(graded_files(handed))
