"""The results of grading: records in memory, and ``results.json``.

The file contains no hidden input, no salt and no run time, so that grading twice gives the same
bytes. Its schema is ``results.schema.json``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, get_args

from fieldcheck.verdict import Verdict
from fieldgrade.isolation.process import CellError
from fieldgrade.isolation.server import Tier
from fieldgrade.sandbox.missing import NOTHING, Missing, validated
from fieldrecon._core.atomic_files import write_atomically

FORMAT, VERSION = "fieldrecon results", 3
NUMBERED = re.compile(r"\d{4,}\.json")

Status = Literal[
    "graded",
    "partly",
    "unreadable",
    "killed: time",
    "killed: memory",
    "killed: output",
    "grader failed",
]
STATUSES: tuple[Status, ...] = get_args(Status)
"""``grader failed``: the grader failed, and the submission is still to be graded."""


@dataclass(frozen=True)
class Grade:
    """The automatic grade of an answer.

    Parameters
    ----------
    question : str
        Its name.
    points, possible : float
        Points earned, and the largest possible number.
    verdict : Verdict
        The verdict, with the sentence for the student.
    check : str
        The check that failed: the public cases, the student's own inputs, or the name of a hidden
        case, which is for instructors; empty if all passed.
    made_by : str
        Digest of all that the verdict depends on, except the answer itself.
    returned : tuple of mapping
        Wrong values on a public case, for a picture: shape and numbers of each array.
    cause : str
        For a function that is missing, or that stops since a name is: the error of the cell that
        should have defined it. Empty if the verdict says it all.
    given : tuple of str
        The earlier questions whose wrong functions the grader replaced by right ones for this
        answer, so that a mistake there costs points once.
    """

    question: str
    points: float
    possible: float
    verdict: Verdict
    check: str = ""
    made_by: str = ""
    returned: tuple[Mapping[str, Any], ...] = ()
    cause: str = ""
    given: tuple[str, ...] = ()


@dataclass(frozen=True)
class Record:
    """A graded submission.

    Parameters
    ----------
    student, file, digest : str
        The student, the name of the file, and the SHA-256 of its content.
    notebook : str
        The number of the notebook; empty if unknown.
    status : str
        How the run ended.
    tier : str
        The tier of the sandbox; empty if it did not run.
    grades : tuple of Grade
        One for each question of the notebook.
    notes : tuple of str
        Notes for the instructor, such as a stub after a working answer.
    code : str
        Digest of the code of its cells and helper files.
    cell_errors : tuple of CellError
        The first error of each cell that has one.
    missing : Missing
        Modules, files and fonts that the code needs and that are not there.
    helper_files : tuple of str
        The files submitted beside it that its code could import or read.
    received, received_by : str
        The time of receipt, and its source: ``"list"``, ``"platform"``, ``"zip"``, ``"file"``.
    late_mark : bool
        Whether the learning platform marked it as late.
    seconds, cpu_seconds : float
        Wall time and processor time.
    peak : int
        Peak memory, in bytes.
    """

    student: str
    file: str
    digest: str
    notebook: str
    status: Status
    tier: Tier | Literal[""]
    grades: tuple[Grade, ...] = ()
    notes: tuple[str, ...] = ()
    code: str = ""
    cell_errors: tuple[CellError, ...] = ()
    missing: Missing = NOTHING
    helper_files: tuple[str, ...] = ()
    received: str = ""
    received_by: str = ""
    late_mark: bool = False
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak: int = 0

    @property
    def points(self) -> float:
        """The points of all questions together."""
        return sum(grade.points for grade in self.grades)

    @property
    def possible(self) -> float:
        """The points that could be earned."""
        return sum(grade.possible for grade in self.grades)


VERDICT_FIELDS = {
    "outcome": "finding",
    "sentence": "sentence",
    "mistake": "mistake",
    "call": "call",
}
"""The attributes of a verdict by their names in the file."""
LISTS = ("notes", "cell_errors", "helper_files")
MEASURED = ("seconds", "cpu_seconds", "peak")
"""Measurements, which differ between runs: they are in the ledger, not in the results."""


@dataclass(frozen=True)
class Results:
    """The results of a class.

    Parameters
    ----------
    records : tuple of Record
        In the order of students and notebooks.
    students : tuple of mapping
        The roster, column by column; without a roster, the names of the submitters.
    questions : tuple of mapping
        The questions, answered in code or in words, with their points.
    secret : bool
        Whether the inputs were drawn from a secret salt.
    environment, grader : str
        Digests of the installed packages and of the grader.
    """

    records: tuple[Record, ...]
    students: tuple[Mapping[str, str], ...] = ()
    questions: tuple[Mapping[str, Any], ...] = ()
    secret: bool = False
    environment: str = ""
    grader: str = ""


PLAIN = ("secret", "environment", "grader")


def to_json(results: Results) -> dict[str, Any]:
    """Return results as data for ``json``."""
    head = {"format": FORMAT, "version": VERSION}
    lists = {"students": list(results.students), "questions": list(results.questions)}
    records = [record_to_json(record) for record in results.records]
    return head | {name: getattr(results, name) for name in PLAIN} | lists | {"records": records}


def record_to_json(record: Record) -> dict[str, Any]:
    """Return a record as data for ``json``, without measurements."""
    data = {k: v for k, v in asdict(replace(record, grades=())).items() if k not in MEASURED}
    grades = [_grade_to_json(grade) for grade in record.grades]
    sums = {"points": record.points, "possible": record.possible}
    lists: dict[str, Any] = {name: [*data[name]] for name in LISTS}
    lists["missing"] = {kind: [*names] for kind, names in data["missing"].items()}
    return data | sums | lists | {"grades": grades}


def _grade_to_json(grade: Grade) -> dict[str, Any]:
    verdict = {name: getattr(grade.verdict, own) for name, own in VERDICT_FIELDS.items()}
    lists = {"returned": [*grade.returned], "given": [*grade.given]}
    return asdict(grade) | {"verdict": verdict} | lists


def from_json(data: Any) -> Results:
    """Return the results that `to_json` wrote.

    Raises
    ------
    ValueError
        The data do not conform to the schema, or have a later version.
    """
    _require_version(data)
    problem = invalid(data)
    if problem:
        raise ValueError(f"the results are damaged: {problem}")
    records = tuple(map(record_from_json, data["records"]))
    plain = {name: data[name] for name in PLAIN}
    return Results(records, tuple(data["students"]), tuple(data["questions"]), **plain)


def require_known_version(file: Path) -> None:
    """Refuse a file of results that another version wrote, without reading all of it.

    Raises
    ------
    ValueError
        The version is not `VERSION`, or the file is damaged; the message names the file.
    """
    try:
        _require_version(json.loads(file.read_text(encoding="utf-8")))
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


def _require_version(data: Any) -> None:
    """Refuse results of another version: their fields have other names or other meanings."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise ValueError("this is not a file of results")
    version = data.get("version")
    if version != VERSION:
        raise ValueError(
            f"the results have version {version}, and this program reads version {VERSION}: they "
            "were written by another version of fieldrecon. Grade all submissions again into a new "
            "folder: fieldrecon grade DIR --out NEW"
        )


def record_from_json(data: Mapping[str, Any]) -> Record:
    """Return the record that `record_to_json` wrote."""
    kept = {k: v for k, v in data.items() if k not in ("points", "possible")}
    grades = tuple(map(_grade_from_json, data["grades"]))
    lists = {name: tuple(data.get(name, ())) for name in LISTS}
    errors = {"cell_errors": tuple(CellError(**error) for error in lists["cell_errors"])}
    missing = {"missing": validated(data["missing"])}
    return Record(**kept | lists | errors | missing | {"grades": grades})


def _grade_from_json(data: Mapping[str, Any]) -> Grade:
    fields = {own: data["verdict"][name] for name, own in VERDICT_FIELDS.items()}
    verdict = Verdict(data["question"], **fields)
    lists = {name: tuple(data.get(name, ())) for name in ("returned", "given")}
    return Grade(**{**data, "verdict": verdict} | lists)


@cache
def schema() -> dict[str, Any]:
    """Return the JSON Schema of the file."""
    text = (files("fieldgrade.checking") / "results.schema.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def invalid(data: Any) -> str:
    """Return the first violation of the schema; empty if there is none."""
    from jsonschema import Draft202012Validator

    error = next(Draft202012Validator(schema()).iter_errors(data), None)
    return "" if error is None else f"{error.json_path}: {error.message}"


def write_results(results: Results, file: Path) -> bool:
    """Write results atomically; return whether they differ from the previous ones.

    The previous results are kept in ``history/`` beside the file.
    """
    text = json.dumps(to_json(results), indent=1, ensure_ascii=True) + "\n"
    before = file.read_bytes() if file.is_file() else None
    if before == text.encode():
        return False
    if before is not None:
        write_atomically(_next(file.parent / "history"), before)
    write_atomically(file, text.encode())
    return True


def _next(history: Path) -> Path:
    """Return the path of the next file of a history: ``0001.json`` and so on."""
    numbers = (int(f.stem) for f in history.glob("*.json") if NUMBERED.fullmatch(f.name))
    return history / f"{max(numbers, default=0) + 1:04}.json"


def read_results(file: Path) -> Results:
    """Return the results in a file.

    Raises
    ------
    ValueError
        The file does not contain valid results; the message names the file.
    """
    try:
        return from_json(json.loads(file.read_text(encoding="utf-8")))
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None


def ordered(records: Iterable[Record]) -> tuple[Record, ...]:
    """Return records in the order of students, notebooks and files."""
    return tuple(sorted(records, key=lambda r: (r.student, r.notebook, r.file, r.digest)))


def merged(before: Iterable[Record], now: Iterable[Record]) -> tuple[Record, ...]:
    """Return earlier records, replaced by those of a new run.

    If the run graded only some questions of the same file, the earlier grades of the other
    questions are kept; for a new file they are dropped. The record of an unreadable file is dropped
    once a file of that name has been read.
    """
    kept = {_whose(record): record for record in before}
    for record in now:
        kept.pop((record.student, "", record.file), None)
        kept[_whose(record)] = _completed(record, kept.get(_whose(record)))
    return ordered(kept.values())


def _completed(record: Record, old: Record | None) -> Record:
    """Return a record completed by the grades of an earlier record of the same file."""
    asked = {grade.question for grade in record.grades}
    rest = [grade for grade in old.grades if grade.question not in asked] if old else []
    if old is None or old.digest != record.digest or not rest:
        return record
    grades = sorted((*record.grades, *rest), key=lambda grade: _order(grade.question))
    status = max(record.status, old.status, key=STATUSES.index)
    return replace(record, grades=tuple(grades), status=status)


def _whose(record: Record) -> tuple[str, ...]:
    own = (record.student, record.notebook)
    return own if record.notebook else (*own, record.file)


def _order(question: str) -> tuple[int, ...]:
    return tuple(int(part) for part in question.split("."))
