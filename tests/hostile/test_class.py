"""A class in which a seventh of the submissions are hostile: killed, resumed and graded again.

``FIELDRECON_STUDENTS=300`` makes it as large as a real class, of all notebooks; then the test takes
some minutes.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fieldcheck.questions import questions
from grader_memory import peak_memory
from hostile.case import HERE, ROOT, as_file, notebook
from hostile.test_submissions import FAMILIES

STUDENTS = int(os.environ.get("FIELDRECON_STUDENTS", "14"))
WORKERS = 16
MOST_MEMORY = 1 << 30
NUMBERS = sorted({question.notebook for question in questions().values()})
GRADER = """
import sys
from fieldgrade.grading import options
from fieldrecon.cli.main import main
options.fitting_jobs = lambda jobs, _: (jobs, "")  # as on a machine with enough memory for all
sys.exit(main())
"""
COMMANDS = ("feedback", "export", "analysis", "similarity")


def hostile_cases():
    """The hostile cases of this class, one for every seven students, from all families in turn."""
    families = [[c for c in its if HERE[0] in c.tiers] for its in FAMILIES.values()]
    deepest = max(map(len, families))
    in_turn = [its[k] for k in range(deepest) for its in families if k < len(its)]
    return in_turn[: STUDENTS // 7]


def write_class(folder):
    """Write all submissions; return the fair points of each student."""
    hostile, fair = hostile_cases(), {}
    for k in range(STUDENTS):
        student = folder / f"s{k:03}"
        student.mkdir(parents=True)
        if k % 7 == 5 and hostile:
            case = hostile.pop(0)
            nowhere = dict.fromkeys(("CANARY", "OUT", "ROOT", "HOME", "UNIX"), "/nowhere")
            numbers = dict.fromkeys(("MARK", "SECRET", "GRADER", "TCP", "UDP", "UNREAD"), "99999")
            name, content = case.submitted_file(nowhere | numbers)
            for path, helper in case.helpers.items():
                if path.isprintable() and len(path) < 100 and not {"..", "/"} & {*Path(path).parts}:
                    file = student / path
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_bytes(helper.encode() if isinstance(helper, str) else helper)
            fair[student.name] = {} if case.status == "unreadable" else case.fair_points()
        else:
            number = NUMBERS[k % len(NUMBERS)]
            name, content = as_file(notebook(number))
            its = (q for q in questions().values() if q.notebook == number)
            fair[student.name] = {q.name: float(q.points) for q in its}
        (student / name).write_bytes(content)
    return fair


def command(folder, out, workers=WORKERS):
    options = ["--out", out, "--root", str(ROOT), "--tier", HERE[0], "--jobs", str(workers)]
    return [sys.executable, "-c", GRADER, "grade", str(folder / "in"), *options]


def graded_students(out):
    file = out / "ledger.jsonl"
    lines = file.read_bytes().split(b"\n")[:-1] if file.exists() else []
    return [json.loads(line)["student"] for line in lines]


def kill_in_the_middle(folder):
    """Begin to grade, kill the grader after a third of the class, and return who was graded."""
    process = subprocess.Popen(command(folder, str(folder / "out"), 4), stdout=subprocess.DEVNULL)
    while len(graded_students(folder / "out")) < STUDENTS // 3:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait(600)
    return graded_students(folder / "out")


@pytest.fixture(scope="module")
def a_class(tmp_path_factory):
    """The folder of the class, the fair points, who was graded at first, and the peak memory."""
    folder = tmp_path_factory.mktemp("class")
    fair = write_class(folder / "in")
    before = kill_in_the_middle(folder)
    resumed, _ = peak_memory(command(folder, str(folder / "out"), 4))
    again, peak = peak_memory(command(folder, str(folder / "again")))
    print(f"{STUDENTS} students, {WORKERS} workers: {peak >> 20} MiB")
    assert (resumed, again) == (3, 3)
    return folder, fair, before, peak


def is_graded_like_one_that_was_not_killed(folder, before):
    """The results are the same, and at most one who was graded before is graded again."""
    results = [(folder / out / "results.json").read_bytes() for out in ("out", "again")]
    assert results[0] == results[1]
    students = graded_students(folder / "out")
    assert len({*before} & {*students[len(before) :]}) <= 1
    assert sorted(set(students)) == sorted(set(graded_students(folder / "again")))


def every_student_has_the_fair_points(folder, fair):
    """No hostile submission changes the points of anybody."""
    found = {
        record["student"]: {grade["question"]: grade["points"] for grade in record["grades"]}
        for record in json.loads((folder / "again" / "results.json").read_text())["records"]
    }
    assert {s: (found[s], fair[s]) for s in fair if found[s] != fair[s]} == {}


def a_second_run_has_nothing_to_do(folder):
    before = graded_students(folder / "again")
    again = subprocess.run(command(folder, str(folder / "again")), capture_output=True)
    assert again.returncode == 3
    assert graded_students(folder / "again") == before


def no_submission_stops_the_command(name, folder, fair):
    """The pages and tables of the whole class are written."""
    program = Path(sys.executable).with_name("fieldrecon")
    done = subprocess.run(
        [program, "course", name, str(folder / "again")], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    if name == "feedback":
        assert len(list((folder / "again" / "feedback").glob("*.html"))) >= len(fair)


@pytest.mark.slow
def test_a_class_with_hostile_submissions(a_class, subtests):
    """One test, so that the class is graded in one process of pytest-xdist only."""
    folder, fair, before, peak = a_class
    with subtests.test("killed and resumed"):
        is_graded_like_one_that_was_not_killed(folder, before)
    with subtests.test("fair points"):
        every_student_has_the_fair_points(folder, fair)
    with subtests.test("the grader's own memory; sandboxes have limits of their own"):
        assert peak < MOST_MEMORY or sys.platform != "linux"  # it is read from /proc
    with subtests.test("a second run"):
        a_second_run_has_nothing_to_do(folder)
    for name in COMMANDS:
        with subtests.test(name):
            no_submission_stops_the_command(name, folder, fair)
