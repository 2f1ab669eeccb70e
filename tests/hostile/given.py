"""Answers that are given right functions of earlier questions: what they try to gain from them.

In notebook 01, 01.2, 01.3 and 01.6 call 01.1. If only 01.1 is wrong, only its points are lost.
"""

from hostile.case import ALL, Case
from hostile.cheats import FORGER

WRONG = "def basis_matrix(points):\n    return np.insert(points, 0, 2.0, axis=1)\n"
IS_GIVEN = "basis_matrix(np.zeros((1, 1)))[0, 0] == 1"
"""Whether the function is the right one."""
DEFINE = "def fit(points, values):\n"
SOLVE = "    return np.linalg.solve(b.T @ b, b.T @ values)\n"
FIT = f"{DEFINE}    b = basis_matrix(points)\n{SOLVE}"
ASK = """
def asked(name, arrays):
    import struct
    described = [["f", list(a.shape)] for a in arrays]
    body = b"".join(a.astype("<f8").tobytes() for a in arrays)
    arguments = [{"array": k} for k in range(len(arrays))]
    frame = {"frame": their("number")["frame"], "asks": name, "named": [], "arrays": described}
    forged(frame | {"arguments": arguments}, body)
    incoming, reply = their("incoming"), b""
    import select
    while select.select([incoming], [], [], 0.5)[0]:
        reply += os.read(incoming, 1 << 16)
    size, length = struct.unpack("!II", reply[:8])
    return np.frombuffer(reply[8 + size :], "<f8")
"""


def given(name, fit, wrong=WRONG, lost=("01.1", "01.2"), before="", **more):
    """A case in which 01.1 is wrong, so that `fit` is given a right `basis_matrix`."""
    answers = {"basis_matrix": wrong, "fit": fit}
    return Case(name, lost=lost, before=before, answers=answers, tiers=ALL, **more)


def revealing(name, how, **more):
    """A case in which `fit` reveals a secret word if it has got a right value."""
    indented = how.replace("\n", "\n        ")
    fit = f'WORD = "@SECRET@"\ndef fit(points, values):\n    if {IS_GIVEN}:\n        {indented}\n'
    return given(name, f"{fit}    return np.zeros(points.shape[1] + 1)\n", **more)


HONEST = [
    given("a right answer that calls a wrong one", FIT, lost=("01.1",)),
    given(
        "a right answer that calls a missing one",
        FIT.replace("basis_matrix(", "basis_matrix(points="),
        "def basis_matrix(points):\n    raise NotImplementedError\n",
        lost=("01.1",),
    ),
    given(
        "a right answer that changes what it was given",
        FIT.replace("    return", "    b *= 1\n    b[0] += 0\n    return"),
        "def basis_matrix(points):\n    return points\n",
        lost=("01.1",),
    ),
    given("a wrong answer that calls a wrong one", FIT.replace("return", "return -")),
    given("a stub that calls nothing", "def fit(points, values):\n    raise NotImplementedError\n"),
]

STOLEN = [
    given(
        "a given function kept for the question that it answers",
        "import builtins\n"
        f"{DEFINE}    builtins.STOLEN = basis_matrix\n    b = basis_matrix(points)\n{SOLVE}",
        "import builtins\ndef basis_matrix(points):\n"
        "    return getattr(builtins, 'STOLEN', np.zeros_like)(points)\n",
        lost=("01.1",),
    ),
    given(
        "given values written to a file",
        "def fit(points, values):\n    b = basis_matrix(points)\n"
        "    open('known.json', 'a').write(repr((points.tolist(), b.tolist())) + '\\n')\n"
        "    return np.linalg.solve(b.T @ b, b.T @ values)\n",
        "def basis_matrix(points):\n    import os\n"
        "    lines = open('known.json') if os.path.exists('known.json') else ()\n"
        "    known = {repr(key): value for key, value in map(eval, lines)}\n"
        "    return np.array(known.get(repr(points.tolist()), points.tolist()))\n",
        lost=("01.1",),
    ),
    given(
        "a given function in place of an answer",
        "def fit(points, values):\n    return basis_matrix(points)\n",
    ),
    given(
        "requests forged where no function is given",
        FIT,
        "def basis_matrix(points):\n    return asked('basis_matrix', [points]).reshape(3, -1)\n",
        before=FORGER + ASK,
        lost=("01.1",),
    ),
    given(
        "requests for functions that are not given",
        f"def fit(points, values):\n    if {IS_GIVEN}:\n"
        "        return asked('fit', [points, values])\n    return values[:1]\n",
        before=FORGER + ASK,
    ),
]

TOO_MUCH = [
    given(
        "calls without end",
        f"def fit(points, values):\n    while {IS_GIVEN}: pass\n    return values[:1]\n",
    ),
    given(
        "requests whose replies nobody reads",
        f"def fit(points, values):\n    count = 10**5 * ({IS_GIVEN})\n"
        "    for _ in range(count):\n"
        "        head = their('number')\n"
        "        forged(head | {'asks': 'basis_matrix', 'arguments': [{'array': 0}],\n"
        "                'named': [], 'arrays': [['f', [9, 9]]]}, bytes(648))\n"
        "    return values[:1]\n",
        before=FORGER,
    ),
    given(
        "huge arguments",
        "def fit(points, values):\n    for shape in ((10**6, 3), (1, 10**6), (10**5, 1)):\n"
        "        b = basis_matrix(np.ones(shape))\n" + SOLVE,
    ),
    given(
        "arguments that are no numbers",
        "def fit(points, values):\n    b = basis_matrix(points, object(), print, 'text', {1: 2})\n"
        + SOLVE,
    ),
    given(
        "endless recursion through a given function",
        "def fit(points, values):\n    return basis_matrix(fit(basis_matrix(points), values))\n",
    ),
    Case(
        "arguments for which a right function needs much memory",
        number="02",
        lost=("02.1", "02.4"),
        answers={
            "weights": "def weights(points, x, epsilon):\n    return np.zeros((1, 1))\n",
            "field": "def field(points, values, x, epsilon):\n"
            "    many = np.ones((5000, 3))\n"
            "    weights(many, many, epsilon)\n    return np.zeros(len(x))\n",
        },
    ),
]

REVEALING = [
    revealing("a right value in an error", "text = WORD\nraise ValueError(text)"),
    revealing(
        "a right value in a missing module", "import importlib\nimportlib.import_module(WORD)"
    ),
    revealing("a right value in a kind of object", "return type(WORD, (), {})()"),
    revealing("a right value in the exit status", "import os\nprint(WORD)\nos._exit(3)"),
]

CASES = [*HONEST, *STOLEN, *TOO_MUCH, *REVEALING]
