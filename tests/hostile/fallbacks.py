"""Modules that are not there, code that goes on without them, and folders that it writes into."""

from hostile.case import Case
from hostile.running import FIT, case, fitted

TRY = """
try:
    import numba_not_here as nb
    HAS = True
except ImportError:
    nb, HAS = None, False
"""
NUMBA = "numba_not_here"


def failing(name, code, missing, **more):
    """A case in which the code that should do without a module fails, and `fit` with it."""
    return Case(f"fallback: {name}", lost=("01.2",), answers={"fit": code}, missing=missing, **more)


FAILING = [
    failing("none", f"{TRY}def fit(points, values):\n    return nb.jit(points)", NUMBA),
    failing("refused", f"{TRY}def fit(points, values):\n    if not HAS: raise KeyError", NUMBA),
    failing(
        "all names of a module",
        "try:\n    from utils_not_here import *\nexcept ImportError:\n    pass\n"
        "def fit(points, values):\n    return ones_of(points)",
        "utils_not_here",
    ),
    failing(
        "the function itself",
        "import contextlib\nwith contextlib.suppress(ImportError):\n"
        "    from mine_not_here import fit",
        "mine_not_here",
    ),
    failing(
        "in a helper file",
        "from helper import fit",
        "scipy_not_here",
        helpers={
            "helper.py": "try:\n    import scipy_not_here as sp\n"
            "except ImportError:\n    sp = None\n"
            "def fit(points, values):\n    return sp.solve(points)\n"
        },
    ),
    failing(
        "in the answer",
        "def fit(points, values):\n    try:\n        import torch_not_here as t\n"
        "    except ImportError:\n        t = None\n    return t.lstsq(points)",
        "torch_not_here",
    ),
    failing(
        "looked for",
        "import importlib.util\nHAS = importlib.util.find_spec('jax_not_here') is not None\n"
        "def fit(points, values):\n    assert HAS",
        "jax_not_here",
    ),
    fitted(
        "fallback: an end in the handler",
        "try:\n    import numba_not_here\n"
        "except ImportError:\n    raise SystemExit('no') from None\n" + FIT,
        missing=NUMBA,
    ),
    case("fallback: used in a cell", after=f"{TRY}print(nb.njit)", missing=NUMBA),
]

WORKING = [
    fitted("fallback: another way", f"{TRY}\nif HAS: print(nb.njit)\n{FIT}"),
    fitted(
        "fallback: a decorator",
        "try:\n    from numba_not_here import njit\n"
        "except ImportError:\n    njit = lambda function: function\n"
        + FIT.replace("def fit", "@njit\ndef fit"),
    ),
    case("fallback: an error of something else", before=TRY, after="1 / 0"),
    Case(
        "fallback: an answer that is wrong without it",
        lost=("01.2",),
        answers={"fit": "def fit(points, values):\n    return 1 / 0"},
        after=TRY,
    ),
    case("fallback: defined again", before=TRY, after="nb = np\nprint(nb.nothing_of_this_name)"),
]
"""No module is missing: nothing has failed without it."""

WRITING = [
    fitted(
        "writing: figures",
        "from matplotlib import pyplot as plt\nplt.plot([1, 2])\n"
        f"plt.savefig('figures/one.png')\nplt.savefig('figures/deep/two.pdf')\n{FIT}",
    ),
    fitted(
        "writing: in an answer",
        FIT.replace(
            "    b", "    np.save('out/b', values); np.savetxt('out/x/b.txt', values)\n    b", 1
        ),
    ),
    fitted(
        "writing: folders",
        "from pathlib import Path\nPath('a/b').mkdir()\nPath('a/c/x.txt').write_text('x')\n"
        "import os\nos.makedirs('a/b', exist_ok=True)\n"
        f"assert os.listdir('a/c') == ['x.txt']\n{FIT}",
    ),
    fitted(
        "writing: outside",
        f"open('/content/drive/x.png', 'w')\nopen('../../up/x', 'wb')\nopen('', 'w')\n{FIT}",
    ),
    fitted(
        "writing: then another file is read",
        f"open('out/x.txt', 'w').write('1')\nopen('out/y.txt')\nopen('z', 'r+b')\n{FIT}",
        missing_files=("out/y.txt", "z"),
    ),
]

CASES = [*FAILING, *WORKING, *WRITING]
