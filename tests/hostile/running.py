"""Honest notebooks that run in Jupyter: imports, names, stubs, magics, and cells that stop."""

from hostile.case import ALL, FUNCTIONS, Case, as_file, code_cell

FIT = """
def fit(points, values):
    b = basis_matrix(points)
    return np.linalg.solve(b.T @ b, b.T @ values)
"""


def case(name, **more):
    """A case in which nothing is lost."""
    return Case(name, tiers=ALL, **more)


def fitted(name, code, **more):
    """A case in which `code` replaces the cell that defines `fit`."""
    return case(name, answers={"fit": code}, **more)


def imports(above, name, missing="", **more):
    """A case with lines above the imports that are handed out, in the same cell."""

    def make(made):
        first = next(c for c in made["cells"] if c["cell_type"] == "code")
        first["source"] = f"{above}\n{first['source']}"
        return as_file(made)

    return case(name, make=make, missing=missing, **more)


PARTS = "scipy.not_here_any_more numpy.not_here"
IMPORTED = [
    imports("import pandas_not_here as pd", "pandas", "pandas_not_here"),
    imports("import matplotlib\nmatplotlib.use('TkAgg')", "TkAgg"),
    imports("import matplotlib as m\nm.rcParams['backend'] = 'QtAgg'\nm.pyplot.figure()", "QtAgg"),
    imports(
        "import tqdm_of_mine, json, pandas_not_here.io.excel\n"
        "from seaborn_not_here import set_theme, heatmap\nset_theme()",
        "several in a line",
        "tqdm_of_mine pandas_not_here seaborn_not_here",
    ),
    imports(
        "from numba_not_here import njit\nfor file in open('not here'): print(file)",
        "numba",
        "numba_not_here",
        missing_files=("not here",),
    ),
    imports(
        "from google_not_here.colab import drive\ndrive.mount('/content/drive')\n"
        "%cd /content/drive/MyDrive",
        "a drive that is not here",
        "google_not_here",
    ),
    imports(
        "import matplotlib.pyplot as p\np.style.use('not here')\n%matplotlib widget", "a style"
    ),
    imports(
        "from scipy import not_here_any_more\nimport numpy.not_here", "parts of libraries", PARTS
    ),
    imports(
        "import sys; sys.path.append('..')\nfrom utils_not_here import *\nset_up(plt)",
        "a helper file that was not submitted",
        "utils_not_here",
    ),
    fitted(
        "an import that is needed by nothing below",
        f"import sympy_not_here\nsympy_not_here.init_printing(){FIT}",
        missing="sympy_not_here",
    ),
    fitted("a plot that fails above an answer", f"print(undefined_name)\nTOL = 1e-9\n{FIT}"),
    fitted("an answer below an assertion", f"assert fit_is_tested, 'not yet'\n{FIT}"),
    fitted("an answer below the end of a cell", f"import sys; sys.exit()\n{FIT}"),
    fitted(
        "nothing waits for what has failed",
        f"error = measured()\nwhile error > 1: pass\n{FIT}",
        status="graded",
    ),
]

HELPERS = [
    fitted(
        "a helper file",
        "from helper import fit",
        helpers={
            "helper.py": f"import numpy as np\nfrom lib.bases import basis_matrix\n{FIT}",
            "lib/bases.py": "import numpy as np\ndef basis_matrix(points):\n"
            "    return np.hstack([np.ones((len(points), 1)), points])\n",
        },
    ),
    fitted(
        "a helper file with everything",
        "from mymod import *",
        helpers={
            "mymod.py": f"import numpy as np\nfrom test import *\n{FIT}",
            "test.py": "import numpy as np\ndef basis_matrix(points):\n"
            "    return np.hstack([np.ones((len(points), 1)), points])\n",
        },
    ),
    case(
        "helper files with the names of libraries",
        helpers={
            "numpy.py": "1 / 0",
            "scipy.py": "1 / 0",
            "fieldcheck.py": "1 / 0",
            "json.py": "1 / 0",
        },
        notes="numpy.py is not used",
        before="import numpy, scipy.linalg, json, fieldcheck\njson.dumps([1]), numpy.ones(1)",
    ),
    fitted(
        "a helper file that is run",
        "%run helper.py",
        helpers={"helper.py": FIT},
    ),
]

NAMES = [
    fitted(name, code)
    for name, code in {
        "an annotated lambda": "from typing import Callable\nfit: Callable = lambda p, v: "
        "np.linalg.lstsq(basis_matrix(p), v, rcond=None)[0]",
        "two names at once": FIT.replace("def fit", "def _fit") + "fit, other = _fit, None",
        "a walrus": FIT.replace("def fit", "def _fit") + "print(fit := _fit)",
        "a match": FIT.replace("def fit", "def _fit") + "match _fit:\n    case fit: pass",
        "a global in a function": "def define():\n    global fit\n"
        + FIT.replace("\n", "\n    ")
        + "\ndefine()",
        "globals()": FIT.replace("def fit", "def _fit") + "globals()['fit'] = _fit",
        "exec": f"exec({FIT!r})",
        "an object that can be called": "class Fit:\n    def __call__(self, points, values):\n"
        "        b = basis_matrix(points)\n"
        "        return np.linalg.solve(b.T @ b, b.T @ values)\nfit = Fit()",
        "a partial function": "import functools\ndef general(ridge, points, values):\n"
        "    b = basis_matrix(points)\n    return np.linalg.solve(b.T @ b + ridge, b.T @ values)\n"
        "fit = functools.partial(general, 0.0)",
        "a decorator": "import functools\ndef plain(function):\n    @functools.wraps(function)\n"
        f"    def inner(*args): return function(*args)\n    return inner\n@plain{FIT}",
        "a loop variable": FIT.replace("def fit", "def _fit") + "for fit in [_fit]: pass",
        "globals().update": FIT.replace("def fit", "def _fit") + "globals().update(fit=_fit)",
        "other code": FIT.replace("def fit", "def _fit")
        + "def fit(points, values): return 0\nfit.__code__ = _fit.__code__",
        "a method": "class Plane:\n    def fit(self, points, values):\n"
        "        b = basis_matrix(points)\n"
        "        return np.linalg.solve(b.T @ b, b.T @ values)\nfit = Plane().fit",
        "the main guard": "if __name__ == '__main__':" + FIT.replace("\n", "\n    "),
        "an attribute of the main module": FIT.replace("def fit", "def _fit")
        + "import __main__\nsetattr(__main__, 'fit', _fit)",
        "a class that is called": "class fit(np.ndarray):\n"
        "    def __new__(cls, points, values):\n        b = basis_matrix(points)\n"
        "        return np.linalg.solve(b.T @ b, b.T @ values).view(np.ndarray)",
        "a cell of 300 KiB": f"TABLE = [{'0.25, ' * 52_000}]\n{FIT}",
        "a cell of 300 KiB of other letters": f"TEXT = '''{'Привет ' * 52_000}'''\n{FIT}",
        "a deep expression that is raised": f"{FIT}\ndef unused():\n    x = 1\n"
        f"    raise ValueError({'1 + ' * 1500}1)",
        "a literal of many digits that is raised": f"{FIT}\ndef unused():\n    x = 1\n"
        f"    raise ValueError(0x{'f' * 5000})",
        "a binary literal that is raised": f"{FIT}\ndef unused():\n    x = 1\n"
        f"    raise ValueError(0b{'1' * 20_000})",
        "an octal literal that is asserted": f"{FIT}\ndef failing(x):\n    y = x\n"
        f"    assert not y, 0o{'7' * 6000}\nfailing(1)",
    }.items()
]

NAMES += [
    case("names of answers used for values", after="rank = rank(np.eye(3)); fit = gradient = 3"),
    case("an answer deleted at the end", after="del evaluate, basis_matrix"),
]

# A script has no metadata: its functions alone tell to which notebook it belongs.
NAMES += [
    case(
        "a script that defines all by exec",
        make=lambda made: (
            "work.py",
            "\n".join(
                f"exec({c['source']!r})" for c in made["cells"] if c["cell_type"] == "code"
            ).encode(),
        ),
    ),
]


def stubs(name, change, **more):
    """A case with handed-out stubs below the answers."""

    def make(made):
        made["cells"] = change(made["cells"])
        return as_file(made)

    return case(name, make=make, notes="a stub is defined after an answer", **more)


def original(function):
    """The cell that `start_over` inserts."""
    from fieldcheck.notebook import stubs as originals
    from fieldcheck.questions import questions

    (name,) = (q.name for q in questions().values() if q.function == function and q.name < "02")
    return code_cell(originals()[name])


def each_below(cells):
    """Each answer with its original cell below."""
    for cell in cells:
        yield cell
        yield from (original(f) for f in FUNCTIONS if cell["source"].startswith(f"def {f}("))


STUBS = [
    stubs("every answer started over", lambda cells: [*each_below(cells)]),
    stubs("all stubs at the end", lambda cells: [*cells, *map(original, FUNCTIONS)]),
    stubs(
        "stubs above, below and beside",
        lambda cells: [
            *cells[:2],
            original("fit"),
            *cells[2:],
            original("fit"),
            code_cell(FIT + original("fit")["source"]),
            original("fit"),
        ],
    ),
    stubs("stubs twice", lambda cells: [*cells, *map(original, [*FUNCTIONS, *FUNCTIONS])]),
    fitted("a stub below exec", f"exec({FIT!r})\n{original('fit')['source']}"),
    fitted(
        "a stub below a lambda",
        "fit = lambda p, v: np.linalg.lstsq(basis_matrix(p), v, rcond=None)[0]\n"
        + original("fit")["source"],
    ),
    fitted(
        "an answer that calls what is raised below it",
        FIT + "    raise NotImplementedError('01.2 is not written yet')\n",
        before="def fit(points, values):\n    return 0\n",
    ),
]

JUPYTER = [
    fitted(
        "a file written and imported",
        "from mine import fit",
        before="%%writefile mine.py\nimport numpy as np\ndef basis_matrix(points):\n"
        f"    return np.hstack([np.ones((len(points), 1)), points])\n{FIT}",
    ),
    fitted(
        "a file written in two pieces and run",
        "%run 'mine too.py'",
        before="%%file 'mine too.py'\n# begun",
        make=lambda made: as_file(
            made
            | {
                "cells": [
                    *made["cells"][:3],
                    code_cell(f"%%writefile -a 'mine too.py'\n{FIT}"),
                    *made["cells"][3:],
                ]
            }
        ),
    ),
    fitted(
        "a helper file that is run with options",
        "%run -i 'my helper' one two",
        helpers={"my helper.py": FIT},
    ),
    fitted("a folder and an environment", f"%cd ..\n%env A=1\nout = %sql select 1\n{FIT}"),
    fitted("a magic and an operator", "%matplotlib inline\nq = (7\n    % 4\n    ) " + FIT),
    fitted("a magic after text", f"'''\n%not a magic\n'''\n%%not_a_magic\n%timeit sum(\n{FIT}"),
    fitted("a command on two lines", f"!pip install \\\n    numpy 'it\n{FIT}"),
    fitted("a command on three lines", f"if True:\n    !ls \\\n  -l \\\n  -a{FIT}"),
    fitted("await", f"import asyncio\nx = await asyncio.sleep(0.01, 7)\nassert x == 7\n{FIT}"),
    fitted(
        "an answer behind await",
        "import asyncio\nasync def define():\n    return await asyncio.to_thread(lambda: _fit)\n"
        + FIT.replace("def fit", "def _fit")
        + "\nfit = await define()",
    ),
    fitted(
        "async for",
        "async def numbers():\n    yield 1\nasync for n in numbers(): m = n\n"
        + FIT.replace("return", "return m *"),
    ),
    fitted(
        "async with and gather",
        "import asyncio\nasync def one(k):\n    await asyncio.sleep(0)\n    return k\n"
        "async with asyncio.timeout(60):\n"
        f"    assert await asyncio.gather(one(1), one(2)) == [1, 2]{FIT}",
    ),
    fitted("help by question marks", f"fit?\nnp.linalg.solve??\n?np\n{FIT}\nprint(help)"),
    fitted("help", f"help(np.linalg)\nhelp()\n{FIT}"),
    fitted(
        "display and help in an answer",
        FIT.replace("    b", "    display(points); help(fit)\n    b", 1),
    ),
    fitted(
        "a class that is pickled",
        "import pickle\nclass Plane:\n    def __init__(self, c): self.c = c\n"
        + FIT.replace("return ", "return pickle.loads(pickle.dumps(Plane(").rstrip()
        + "))).c",
    ),
    fitted(
        "an object in a file",
        "import pickle, copy\nclass Plane:\n    def __init__(self, c): self.c = c\n"
        + FIT.replace(
            "    return ", "    with open('p', 'wb') as file: pickle.dump(Plane("
        ).rstrip()
        + "), file)\n    with open('p', 'rb') as file: return copy.deepcopy(pickle.load(file)).c",
    ),
    fitted(
        "a data class with annotations in words",
        "from __future__ import annotations\nimport dataclasses, typing\n"
        "@dataclasses.dataclass\nclass Plane:\n    c: np.ndarray\n"
        "assert typing.get_type_hints(Plane)['c'] is np.ndarray\n" + FIT,
    ),
    fitted(
        "an answer as nbconvert exports it below a magic",
        f"get_ipython().run_cell_magic('time', '', {FIT!r})\n"
        "get_ipython().run_line_magic('time', 'y = 7')\nassert y == 7",
    ),
    fitted(
        "an answer put into the names of the user",
        f"{FIT.replace('def fit', 'def _fit')}get_ipython().user_ns['fit'] = _fit",
    ),
    fitted(
        "a helper that displays",
        "from helper import fit",
        helpers={
            "helper.py": "import numpy as np\ndisplay(get_ipython())\nbasis_matrix = lambda p: "
            f"np.hstack([np.ones((len(p), 1)), p])\n{FIT}"
        },
    ),
    case(
        "the shell",
        before="get_ipython().run_line_magic('matplotlib', 'qt')\nshell = get_ipython()\n"
        "shell.kernel.do_shutdown(True)\nshell.config.InlineBackend.figure_format = 'retina'\n"
        "from IPython.display import display, HTML\ndisplay(HTML('<b>x</b>'))",
    ),
]

CRASH = "import ctypes; ctypes.string_at(0)"


def many(name, *cells, **more):
    """A case with scratch cells at the top and at the end."""

    def make(made):
        scratch = [code_cell(code) for code in cells]
        made["cells"] = [*made["cells"][:3], *scratch, *made["cells"][3:], *scratch]
        return as_file(made)

    return case(name, make=make, notes="only the code that the answers need was run", **more)


SCRATCH = [
    many("thirty crashing cells", *["import ctypes", *["ctypes.string_at(0)"] * 15]),
    many("thirty crashes assigned", "import os", *["x = fit and os._exit(1)"] * 15),
    many("thirty crashes in a cell", "\n".join([*["import os"], *["os.abort()"] * 30])),
    many(
        "thirty cells that write too much",
        "import os",
        *["for k in range(1500): open(f'f{k}', 'w').close()"] * 15,
    ),
    many("thirty crashes in functions", "import os", *["def f():\n    os._exit(7)\nf()"] * 15),
    fitted("a crash beside an answer", f"EPS = 0.0\n{CRASH}\n{FIT.rstrip()} + EPS"),
    fitted("a loop below an answer", f"{FIT}\nwhile True: pass\n", status="killed: time"),
    fitted(
        "an answer made of parts between crashes",
        f"{CRASH}\nTABLE = {{}}\n{CRASH}\nTABLE['one'] = 1.0\n{CRASH}\n{CRASH}\n"
        f"def scale(x):\n    return x * TABLE['one']\n{CRASH}\n{CRASH}\n"
        + FIT.replace("return ", "return scale(").rstrip()
        + ")",
        notes="only the code",
    ),
]
