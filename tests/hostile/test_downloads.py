"""Downloads with names that students chose: no file counts for another student, or is lost."""

import pytest

from fieldgrade.class_folder.roster import Student, file_names
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.intake import Intake
from submission_files import ANSWER, FUNCTIONS, notebook, packed, write_files

ADA = Student("4711", "Ada Lovelace", "ada@x.org", "alove", "12", "77", "", "512")
EVE = Student("eve", "Eve Doe", "eve@x.org", "edoe", "1300", "79", "", "519")
ROSTER = {student.student: student for student in (ADA, EVE)}
MINE, THEIRS = notebook(ANSWER), notebook("mischief = 1", ANSWER)

CANVAS = {"lovelaceada_12_345_01.ipynb": MINE}
MOODLE = {"Ada Lovelace_512_assignsubmission_file_/01.ipynb": MINE}
METADATA = """---
submission_901:
  :submitters:
  - :name: Ada Lovelace
    :sid: '77'
    :email: ada@x.org
submission_902:
  :submitters:
  - :name: 'Eve Doe with a name so long that the export continues it in the next line,
      @WRAPPED@'
    :sid: '79'
    :email: eve@x.org
"""


def gradescope(wrapped):
    """An export in which the continued line of a long name imitates a field."""
    return {
        "submission_metadata.yml": METADATA.replace("@WRAPPED@", wrapped).encode(),
        "submission_901/01.ipynb": MINE,
        "submission_902/01.ipynb": THEIRS,
    }


IMITATIONS = {
    "a name of Moodle with a student number": CANVAS
    | {"doeeve_1300_222_x_4711_assignsubmission_file_01.ipynb": THEIRS},
    "a name of Moodle with its number": CANVAS
    | {"doeeve_1300_222_x_512_assignsubmission_file_01.ipynb": THEIRS},
    "a name of Moodle in a late file": CANVAS
    | {"doeeve_LATE_1300_222_Ada Lovelace_512_assignsubmission_file_.ipynb": THEIRS},
    "a name of Canvas in a file of Canvas": CANVAS
    | {"doeeve_1300_222_lovelaceada_12_345_01.ipynb": THEIRS},
    "a zip file with a download of Moodle": CANVAS
    | {
        "doeeve_1300_222_work.zip": packed(
            {"Ada Lovelace_512_assignsubmission_file_/01.ipynb": THEIRS}
        )
    },
    "a name of Canvas in a file of Moodle": MOODLE
    | {"Eve Doe_519_assignsubmission_file_lovelaceada_12_345_01.ipynb": THEIRS},
    "a name of Moodle in a file of Moodle": MOODLE
    | {"Eve Doe_519_assignsubmission_file_Ada Lovelace_512_assignsubmission_file_": THEIRS},
    "a number of Moodle that is a student number": MOODLE
    | {"Eve Doe_4711_assignsubmission_file_/01.ipynb": THEIRS},
    "a number of Moodle that is a number at the university": MOODLE
    | {"Eve Doe_77_assignsubmission_file_/01.ipynb": THEIRS},
    "an address in a long name": gradescope(":email: ada@x.org"),
    "a submitter in a long name": gradescope("- :name: Ada Lovelace"),
    "metadata in the folder of a student": gradescope("")
    | {
        "submission_902/submission_metadata.yml": METADATA.replace(
            ":email: eve@x.org", ":email: ada@x.org"
        ).encode()
    },
}
STRANGERS = {
    "a Canvas name equal to a student number": CANVAS | {"eve_99_346_01.ipynb": THEIRS},
    "a namesake in Canvas": CANVAS | {"lovelaceada_99_346_01.ipynb": THEIRS},
    "a namesake in Moodle": MOODLE | {"Ada Lovelace_599_assignsubmission_file_01.ipynb": THEIRS},
    "a student number in a name of Moodle": MOODLE
    | {"Eve 4711_599_assignsubmission_file_01.ipynb": THEIRS},
}
FOREIGN = {
    "a file of Moodle among those of Canvas": CANVAS
    | {
        "bytebob_13_346_01.ipynb": MINE,
        "Eve Doe_512_assignsubmission_file_01.ipynb": THEIRS,
    },
    "a folder of Moodle among those of Canvas": CANVAS
    | {
        "bytebob_13_346_01.ipynb": MINE,
        "Eve Doe_512_assignsubmission_file_/01.ipynb": THEIRS,
    },
    "a folder of Gradescope among those of Moodle": MOODLE
    | {"Bob_513_assignsubmission_file_/01.ipynb": MINE, "submission_4711/01.ipynb": THEIRS},
}


def taken(tmp_path, files, as_zip, roster=ROSTER):
    """The files and their contents by student, and the strays."""
    place = tmp_path / "class"
    if as_zip:
        place.write_bytes(packed(files))
    else:
        write_files(place, files)
    archive = Archive(tmp_path / "received")
    intake = Intake(archive, FUNCTIONS, roster)
    by_student = {}
    for file in intake.take(place):
        by_student.setdefault(file.student, []).append(file)
    contents = {
        student: [file.submission(archive).content if file.digest else b"" for file in files]
        for student, files in by_student.items()
    }
    return by_student, contents, intake.strays


@pytest.mark.parametrize("as_zip", [False, True], ids=["folder", "zip"])
@pytest.mark.parametrize("files", IMITATIONS.values(), ids=IMITATIONS)
def test_a_file_name_that_imitates_a_platform_counts_for_its_sender(tmp_path, files, as_zip):
    """The victim keeps the own file; the sender has a record, graded or refused in words."""
    by_student, contents, _ = taken(tmp_path, files, as_zip)
    assert contents["4711"] == [MINE]
    assert by_student["4711"][0].notes == ()
    (sent,) = by_student["eve"]
    assert sent.notebook == "01" or "can be read as that of eve and of 4711" in sent.problem


@pytest.mark.parametrize("name", [name for name in IMITATIONS if "Moodle" in name])
def test_a_name_that_imitates_a_platform_has_no_effect_without_a_roster(tmp_path, name):
    """The students are called as in the names of their platform."""
    _, contents, _ = taken(tmp_path, IMITATIONS[name], as_zip=True, roster={})
    senders = [("lovelaceada", "doeeve"), ("Ada Lovelace", "Eve Doe")]
    assert contents in [{ada: [MINE], eve: [THEIRS]} for ada, eve in senders]


def test_each_of_several_downloads_has_its_own_platform(tmp_path):
    """The work of one student is collected from both."""
    other = notebook("def weights(x): return x")
    moodle = dict.fromkeys(MOODLE, other)
    _, contents, strays = taken(
        tmp_path, {"1.zip": packed(CANVAS), "2.zip": packed(moodle)}, as_zip=False
    )
    assert contents == {"4711": [MINE, other]}
    assert strays == []


@pytest.mark.parametrize("files", STRANGERS.values(), ids=STRANGERS)
def test_two_senders_are_never_one_student(tmp_path, files):
    """The stranger has a record of the own, with a note for the instructor."""
    by_student, contents, _ = taken(tmp_path, files, as_zip=False)
    others = {student: found for student, found in contents.items() if THEIRS in found}
    assert len(others) == 1
    (stranger,) = others
    assert stranger not in ROSTER
    assert "is not on the roster" in by_student[stranger][0].notes[-1]
    assert [MINE] in contents.values()
    assert all(MINE not in found for found in others.values())


@pytest.mark.parametrize("files", FOREIGN.values(), ids=FOREIGN)
def test_a_file_of_another_platform_is_refused_by_its_name(tmp_path, files):
    """A download has one platform; nobody's file is replaced."""
    _, contents, strays = taken(tmp_path, files, as_zip=False)
    assert contents["4711"] == [MINE]
    assert THEIRS not in [content for found in contents.values() for content in found]
    (name,) = [name for name, content in files.items() if content == THEIRS]
    assert [stray.partition(":")[0] for stray in strays] == [name]
    assert "its name has the form of" in strays[0]


def test_a_folder_with_downloads_of_two_platforms_is_refused_in_words(tmp_path):
    """The files are listed, since nothing says which platform made the folder."""
    with pytest.raises(ValueError, match="among files of Moodle") as error:
        taken(tmp_path, CANVAS | MOODLE, as_zip=False)
    assert all(name in str(error.value) for name in CANVAS | MOODLE)


def test_files_of_two_names_that_count_for_one_student_are_named(tmp_path):
    """In a folder of the instructor's own, both names are the instructor's."""
    files = {"4711/a.ipynb": MINE, "Ada Lovelace/b.ipynb": notebook("def weights(x): return x")}
    by_student, _, _ = taken(tmp_path, files, as_zip=False)
    assert by_student["4711"][0].notes == ("the files of 4711 and of Ada Lovelace count for 4711",)


ALIKE = {
    "control characters": ("ada\x01", "ada\x02"),
    "letters that are not printed": ("ada\u200b", "ada\u200c"),
    "an escape and its text": ("ada\x07", r"ada\x07"),
    "a letter with an accent, written in two ways": ("ad\u00e9", "ade\u0301"),
}


@pytest.mark.parametrize("names", ALIKE.values(), ids=ALIKE)
def test_two_names_that_look_alike_are_two_students_with_two_pages(tmp_path, names):
    """They differ only in characters that a file name drops."""
    files = {
        f"{name}/01.ipynb": content for name, content in zip(names, (MINE, THEIRS), strict=True)
    }
    _, contents, _ = taken(tmp_path, files, as_zip=False)
    assert sorted(contents.values()) == sorted([[MINE], [THEIRS]])
    assert len(set(file_names(contents).values())) == 2


DOTS = {
    ".eve/01.ipynb": THEIRS,
    ".eve.ipynb": THEIRS,
    ".eve/.work/01.ipynb": THEIRS,
    ".eve.zip": packed({".work/.01.ipynb": THEIRS}),
}


@pytest.mark.parametrize("name", DOTS)
def test_a_student_whose_name_begins_with_a_dot_is_not_skipped(tmp_path, name):
    files = {"4711/01.ipynb": MINE, name: DOTS[name]}
    by_student, contents, _ = taken(tmp_path, files, as_zip=False)
    assert contents == {"4711": [MINE], ".eve": [THEIRS]}
    assert by_student[".eve"][0].notes == (".eve is not on the roster",)
