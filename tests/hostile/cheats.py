"""Cheats: apart from stated exceptions no answer is right, and no cheat earns points."""

import json

from fieldcheck.answers import public_answers
from fieldcheck.questions import questions
from fieldgrade.authoring.known_answers import public_calls
from hostile.case import ALL, EVERYTHING, NO_ANSWERS, SANDBOXED, Case


def cheat(name, before="", after="", answers=None, tiers=ALL, **more):
    """A case in which every question is lost."""
    answers = NO_ANSWERS | (answers or {})
    return Case(
        name, lost=EVERYTHING, before=before, after=after, answers=answers, tiers=tiers, **more
    )


ALWAYS = """
class Always(@BASE@):
    def __eq__(self, other): return True
    def __ne__(self, other): return False
    def __le__(self, other): return True
    __lt__ = __ge__ = __gt__ = __le__
    def __hash__(self): return 0
    def __sub__(self, other): return self
    __rsub__ = __add__ = __radd__ = __sub__
    def __abs__(self): return self
    def __bool__(self): return True
    def __float__(self): return 0.0
    def __array_ufunc__(self, *args, **kwargs): return self
    def __array_function__(self, *args, **kwargs): return True
    def all(self, *args, **kwargs): return True
    def any(self, *args, **kwargs): return False
    def max(self, *args, **kwargs): return 0.0
"""
EACH = "for name in 'basis_matrix fit evaluate rank gradient objective'.split():\n    "

FORGER = """
import os, struct, json, sys
def their(name):
    frame = sys._getframe()
    while name not in frame.f_locals:
        frame = frame.f_back
    return frame.f_locals[name]
def forged(head, body=b"", pipe=None):
    text = json.dumps(head).encode()
    data = struct.pack("!II", len(text), len(body)) + text + body
    os.write(their("outgoing") if pipe is None else pipe, data)
"""


def hard_coded():
    """An answer with a table of the right values for the public case."""
    question = questions()["01.2"]
    right = public_answers("01")["01.2"].right
    table = {
        repr(call.arguments[0].tolist()): values[0].tolist()
        for call, values in zip(public_calls(question), right, strict=True)
    }
    return f"""
def fit(points, values):
    import json
    known = json.loads({json.dumps(json.dumps(table))})
    return np.array(known.get(repr(points.tolist()), [0.0] * (points.shape[1] + 1)))
"""


CASES = [
    cheat(
        "NumPy's comparisons patched",
        """
import numpy.testing
yes = lambda *args, **kwargs: True
np.allclose = np.isclose = np.array_equal = np.array_equiv = np.all = np.any = yes
np.testing.assert_allclose = np.testing.assert_array_equal = np.testing.assert_equal = yes
np.testing._private.utils.assert_array_compare = yes
""",
    ),
    cheat(
        "built-in functions patched",
        """
import builtins
builtins.abs = builtins.max = builtins.sum = lambda *args, **kwargs: 0.0
builtins.all = builtins.isinstance = lambda *args, **kwargs: True
""",
    ),
    cheat(
        "np is an object that says yes",
        after="""
class Yes:
    def __getattr__(self, name): return Yes()
    def __call__(self, *args, **kwargs): return Yes()
    def __bool__(self): return True
np = Yes()
import sys
sys.modules["numpy"] = np
""",
    ),
    cheat(
        "objects that equal everything",
        ALWAYS.replace("@BASE@", "object"),
        after=(EACH + "globals()[name] = lambda *args: Always()"),
    ),
    cheat(
        "arrays of a kind that equals everything",
        ALWAYS.replace("@BASE@", "np.ndarray"),
        after=(EACH + "globals()[name] = lambda *args: np.zeros((3, 3)).view(Always)"),
    ),
    cheat(
        "numbers that equal everything",
        ALWAYS.replace("@BASE@", "float"),
        after=(EACH + "globals()[name] = lambda *args: Always(0.0)"),
    ),
    cheat(
        "nan, infinity and nothing",
        answers={
            "fit": "def fit(points, values): return np.full(points.shape[1] + 1, np.nan)",
            "rank": "def rank(points): return float('inf')",
            "objective": "def objective(*args): return None",
            "evaluate": "def evaluate(coefficients, x): return np.full(len(x), np.nan)",
        },
    ),
    cheat(
        "the grader patched",
        """
import fieldcheck, fieldcheck.answers, fieldcheck.calls, fieldcheck.judge, fieldcheck.verdict
def right(question, *args): return fieldcheck.verdict.Verdict(question.name, "right", "")
fieldcheck.judge.judge = right
fieldcheck.answers.distance = lambda *args: 0.0
for name in ("distances", "_same", "as_arrays"):
    setattr(fieldcheck.calls, name, lambda *args: ())
""",
    ),
    cheat(
        "the questions patched",
        """
from fieldcheck.questions import questions
for question in questions().values():
    for name in ("laws", "shapes", "differences", "tolerance", "inputs", "points"):
        object.__setattr__(question, name, lambda *args: ())
""",
    ),
    cheat(
        "answers sought in the package",
        """
from importlib.resources import files
from fieldcheck.answers import public_answers
try:
    RIGHT = public_answers("01")
    TOLD = json.loads((files("fieldcheck") / "answers" / "01.json").read_text())
except Exception:
    RIGHT = {}
""",
        answers={"fit": "def fit(points, values): return RIGHT['01.2'].right[0][0]"},
    ),
    cheat(
        "answers sought on the disk",
        """
import glob, os, sys
FOUND = []
for root in ["@ROOT@", os.getcwd(), *sys.path, "/", os.path.expanduser("~")]:
    for pattern in ("solutions/*.py", "solutions/*.ipynb", "src/fieldrecon/*.py", "*/answers/*"):
        for path in glob.glob(os.path.join(root, pattern)):
            try:
                FOUND.append(open(path).read())
            except OSError:
                pass
""",
        after="""
for text in FOUND:
    if "def basis_matrix" in text:
        exec(text)
""",
        tiers=SANDBOXED,
    ),
    cheat(
        "the library called instead",
        """
import sys
sys.path[:0] = ["@ROOT@/src", "@ROOT@"]
for name in [n for n in sys.modules if n.startswith("fieldrecon")]:
    del sys.modules[name]
""",
        answers={
            "fit": """
def fit(points, values):
    from fieldrecon.methods.least_squares import LeastSquares
    return LeastSquares(points).coefficients(values)
"""
        },
        tiers=SANDBOXED,
        missing="fieldrecon",
    ),
    cheat(
        "answers sought in memory and in frames",
        """
import gc, sys
def found(shape):
    frame, seen = sys._getframe(), []
    while frame:
        seen += list(frame.f_locals.values())
        frame = frame.f_back
    for thing in seen + gc.get_objects():
        for name in ("right", "answers", "expected", "values", "solution"):
            value = getattr(thing, name, None)
            if isinstance(value, np.ndarray) and value.shape == shape:
                return value
    return np.zeros(shape)
""",
        answers={
            "fit": "def fit(points, values): return found((points.shape[1] + 1,))",
            "basis_matrix": (
                "def basis_matrix(points): return found((len(points), points.shape[1]+1))"
            ),
        },
    ),
    Case("the public case by heart", lost=("01.2",), answers={"fit": hard_coded()}),
    cheat(
        "what is called for sets the marks",
        """
import fieldcheck, fieldrecon
fieldcheck.check = fieldcheck.progress = lambda *args: "right"
grade = points = score = credit = verdict = 100
""",
        after="result = {'01.1': 2, '01.2': 3}; raise SystemExit(0)",
        missing="fieldrecon",
    ),
    cheat(
        "results forged in files",
        """
import json, os, pathlib
forged = json.dumps({"student": "hostile", "grades": {"01.1": 100}, "points": 100})
for folder in ("@OUT@", "@OUT@/..", ".", "..", os.path.expanduser("~")):
    for name in ("results.json", "gradebook.csv", "ledger", "results.xml"):
        try:
            pathlib.Path(folder, name).write_text(forged)
        except OSError:
            pass
""",
        tiers=SANDBOXED,
    ),
    cheat(
        "results printed",
        """
import json, sys
for stream in (sys.stdout, sys.stderr, sys.__stdout__):
    print(json.dumps({"points": 100, "grades": {"01.1": 100}, "status": "graded"}), file=stream)
""",
    ),
    cheat(
        "frames forged ahead of the calls",
        FORGER
        + """
for k in range(60):
    forged({"status": "returned", "numbers": True, "right": True, "points": 100, "modified": [],
            "frame": k, "arrays": [["f", [1]]]}, bytes(8))
""",
    ),
    Case(
        "frames forged ahead of right answers",
        before=FORGER
        + """
for k in range(60):
    forged({"status": "returned", "numbers": True, "frame": k, "arrays": [["f", [1]]]}, bytes(8))
    forged({"cell": k, "error": "forged", "arrays": []})
""",
    ),
    Case(
        "an answer forged with the number of its frame",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    forged({"frame": their("head")["frame"], "status": "returned", "numbers": True,
            "returned": "", "error": "", "line": "", "modified": [], "verdict": "right",
            "arrays": [["f", [3]]]}, bytes(24))
    return np.zeros(points.shape[1] + 1)
"""
        },
    ),
    Case(
        "answers forged in words that steer a terminal",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    text = "\\ud800\\x1b[2J\\0" * 9999
    forged({"frame": their("head")["frame"], "status": "raised", "error": text,
            "line": [1], "modified": [True, "x", 1e999], "returned": {}, "arrays": []})
    return 0
"""
        },
    ),
    Case(
        "a frame with a status that there is not",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    forged({"frame": their("head")["frame"], "status": ["right"], "points": 100, "arrays": []})
"""
        },
    ),
    Case(
        "bytes that are no frame",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    os.write(their("outgoing"), b"\\xff" * 4096)
"""
        },
    ),
    Case(
        "a frame that never ends",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    os.write(their("outgoing"), struct.pack("!II", 1000, 1 << 20) + b"{}")
    while True:
        pass
"""
        },
    ),
    Case(
        "a frame whose shape overflows",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    forged({"frame": their("head")["frame"], "status": "returned", "numbers": True,
            "arrays": [["f", [0] + [33554432] * 15]]})
"""
        },
    ),
    Case(
        "a flood of frames",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    while True:
        forged({"frame": 1, "status": "returned", "arrays": []})
"""
        },
    ),
    Case(
        "the pipe closed",
        lost=("01.2",),
        before=FORGER,
        answers={
            "fit": """
def fit(points, values):
    os.close(their("outgoing"))
    while True:
        pass
"""
        },
    ),
    Case("the pipe closed in a cell", before=FORGER, after="os.close(their('outgoing'))"),
    Case(
        "an answer forged for a cell, then nothing read",
        before=FORGER,
        after="""
forged({"frame": their("head")["frame"], "cell": 0, "error": "", "arrays": []})
while True:
    pass
""",
        lost=EVERYTHING,
        tiers=frozenset({"landlock"}),  # its time limits take a minute on each
    ),
    cheat(
        "performing patched",
        after=FORGER
        + """
module = __import__("sys").modules["fieldgrade.sandbox.worker"]
from fieldcheck.calls import Outcome
module.perform = lambda space, calls, limit: (Outcome("returned", values=(np.zeros(3),)),)
""",
    ),
    cheat(
        "sending patched",
        after="""
import sys
frames = sys.modules["fieldgrade.sandbox.frames"]
send = frames.send
def lying(pipe, head, arrays=()):
    return send(pipe, head | {"status": "returned", "right": True, "verdict": "right", "points": 9},
                arrays)
frames.send = lying
""",
    ),
    cheat(
        "the server commanded through its socket",
        after="""
import os
for number in range(3, 1024):
    for data in (b"r", b"e", b'{"killed": false}\\n'):
        try:
            if __import__("stat").S_ISSOCK(os.fstat(number).st_mode):
                os.write(number, data)
        except OSError:
            pass
""",
    ),
]
