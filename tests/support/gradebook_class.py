"""A class for tests of the gradebook: notebooks with known misconceptions, and made-up records."""

import ast
import json
from html.parser import HTMLParser

from checkout import ROOT
from fieldcheck.questions import questions
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.build import all_sources
from fieldgrade.checking.results import Grade, Record, Results
from fieldgrade.submissions.submission import Submission

DIGEST = "ab" * 32


def source(number):
    return next(s for s in all_sources(ROOT) if s.number == number)


def notebook(number, folder="solutions"):
    return json.loads((ROOT / folder / f"{source(number).name}.ipynb").read_text("utf-8"))


def code_cell(book, function):
    """Return the cell of a notebook that defines a function."""
    return next(
        c
        for c in book["cells"]
        if c["cell_type"] == "code" and f"def {function}(" in "".join(c["source"])
    )


def with_function(book, function, code):
    """Return a notebook in which the cell of a function contains other code."""
    code_cell(book, function)["source"] = code
    return book


def misconception_code(question, mistake):
    """Return the code of a catalogued misconception as a student would submit it."""
    number, function = question.partition(".")[0], questions()[question].function
    path = ROOT / "solutions" / "misconceptions" / f"{source(number).name}.py"
    tree = ast.parse(path.read_text("utf-8"))
    wrong = mistake.replace(" ", "_")
    kept = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.decorator_list:
            if node.name == wrong:
                node.name, node.decorator_list = function, []
                kept.append(node)
        elif "fieldrecon" not in ast.unparse(node) and node is not tree.body[0]:
            kept.append(node)
    return ast.unparse(ast.Module(kept, []))


def submission(student, book, name="handed in.ipynb"):
    return Submission(student, name, json.dumps(book).encode())


def grade(question, points, possible=2.0, finding=None, sentence="", **parts):
    finding = finding or ("right" if points >= possible else "wrong")
    verdict = Verdict(
        question, finding, sentence, parts.pop("mistake", ""), parts.pop("call", None)
    )
    return Grade(question, points, possible, verdict, made_by="0" * 64, **parts)


def record(student, grades, notebook="01", **changes):
    fields = {
        "file": f"{student}.ipynb",
        "digest": DIGEST,
        "status": "graded",
        "tier": "bubblewrap",
    }
    return Record(student, notebook=notebook, grades=tuple(grades), code=DIGEST, **fields | changes)


def asked(*names, points=2.0, kind="code", title=""):
    return tuple(
        {
            "question": name,
            "notebook": name[:2],
            "kind": kind,
            "title": title,
            "points": points,
            "function": "f" if kind == "code" else "",
        }
        for name in names
    )


def results(records, questions=None, students=(), **changes):
    questions = questions or asked("01.1", "01.2") + asked("01.7", kind="words")
    return Results(tuple(records), tuple(students), tuple(questions), **changes)


class Tags(HTMLParser):
    """The tags with their attributes and the text, as a browser sees them."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text = [], ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data


def harmless(page):
    """Whether a page runs no code, loads nothing, and has no links to other pages."""
    tags = Tags(page).tags
    names = {tag for tag, _ in tags}
    attributes = [(name, value or "") for _, its in tags for name, value in its.items()]
    return (
        not names & {"script", "iframe", "object", "embed", "form", "link", "base", "svg"}
        and not any(name.startswith("on") or name == "srcdoc" for name, _ in attributes)
        and all(v.startswith("data:image/svg+xml;base64,") for n, v in attributes if n == "src")
        and all(v.startswith("#") for n, v in attributes if n == "href")
    )
