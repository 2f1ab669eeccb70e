"""Unusual but honest submissions: no right answer loses points."""

from hostile.case import ALL, Case


def odd(name, after="", before="", answers=None, **more):
    """A case in which nothing is lost."""
    return Case(name, after=after, before=before, answers=answers or {}, tiers=ALL, **more)


RIGHT_FIT = """
def fit(points, values):
    b = basis_matrix(points)
    @ODD@
    return np.linalg.solve(b.T @ b, b.T @ values)
"""


def in_fit(name, line, **more):
    """A case in which a right answer contains an additional line."""
    return odd(name, answers={"fit": RIGHT_FIT.replace("@ODD@", line)}, **more)


CASES = [
    in_fit("warnings", "import warnings; warnings.warn('careful'); np.ones(1) / 0; np.log(-1.0)"),
    in_fit("prints", "print(b, 'x' * 1000, flush=True); import sys; print(1, file=sys.stderr)"),
    in_fit("slow but right", "import time; time.sleep(0.05)"),
    in_fit("magics in an answer", "%time x = 1\n    !ls\n    files = !ls"),
    odd("an error in a scratch cell", "1 / 0", before="undefined + 1"),
    odd("a syntax error in a scratch cell", "def (:", before="for x in"),
    odd(
        "magics and commands",
        "%%time\nx = 1",
        before="%matplotlib inline\n%load_ext autoreload\n!pip install x\nnp?",
    ),
    odd("a cell of another language", "%%bash\nrm -rf $HOME/* | grep x", before="%%html\n<b>x</b>"),
    odd("input()", "name = input('Who are you? ')"),
    odd(
        "figures shown",
        """
import matplotlib.pyplot as plt
plt.figure(); plt.plot([1, 2]); plt.show(); plt.savefig("figure.png"); plt.pause(0.01)
display(plt.gcf())
""",
        before="import matplotlib\nmatplotlib.use('TkAgg', force=False)",
    ),
    odd(
        "seeds set",
        "np.random.seed(0); import random; random.seed(0); "
        "np.random.default_rng = lambda *args: 1 / 0",
    ),
    odd("sys.exit in a scratch cell", "exit()", before="import sys; sys.exit(1)"),
    odd(
        "a package that is not here",
        "import pandas_but_not_here",
        before="import torch_but_not_here.nowhere",
        missing="torch_but_not_here pandas_but_not_here",
    ),
    odd(
        "names used again",
        "x = points = values = data = check = progress = draw = 3",
        before="list = [1, 2]; sum = 3; type = str",
    ),
    odd("np.seterr(all='raise')", before="np.seterr(all='raise')"),
    odd("warnings as errors", before="import warnings; warnings.simplefilter('error')"),
    odd("other print options", before="np.set_printoptions(precision=1, threshold=1)"),
    odd(
        "another folder",
        before="import os; os.makedirs('work'); os.chdir('work')",
        after="os.chdir('..'); os.rmdir('work')",
    ),
    odd(
        "files of one's own",
        "np.save('mine.npy', np.ones(3)); np.load('mine.npy'); "
        "open('notes.txt', 'w').write('x'); import tempfile; tempfile.TemporaryFile().write(b'x')",
    ),
    in_fit(
        "a database",
        """import sqlite3
    for _ in range(2):
        with sqlite3.connect('mine.db', isolation_level='EXCLUSIVE') as base:
            base.execute('create table if not exists mine (x)')
            base.execute('insert into mine values (1)')
    assert base.execute('select count(*) from mine').fetchone()[0] >= 2""",
    ),
    in_fit(
        "locked files",
        """import fcntl
    with open('mine.txt', 'w') as file:
        fcntl.flock(file, fcntl.LOCK_EX); fcntl.lockf(file, fcntl.LOCK_EX)
        fcntl.lockf(file, fcntl.LOCK_UN)""",
    ),
    in_fit(
        "arrays in files",
        """np.save('mine.npy', b)
    np.savez_compressed('mine.npz', b=b)
    b = np.array(np.load('mine.npy', mmap_mode='r')) + 0 * np.load('mine.npz')['b']""",
    ),
    odd(
        "threads of one's own",
        "from concurrent.futures import ThreadPoolExecutor\n"
        "with ThreadPoolExecutor(4) as pool: assert sum(pool.map(abs, range(9))) == 36",
    ),
    odd(
        "checks of one's own",
        "assert check('01.1') == 'right'",
        before="import fieldcheck.notebook\nfieldcheck.notebook.check('01.1', {})",
    ),
    odd(
        "annotations and decorators",
        answers={
            "fit": """
import functools
@functools.lru_cache(maxsize=None)
def constant() -> "np.ndarray": return np.ones(1)
@functools.wraps(len)
def wrapper(*args): return args
def fit(points: "np.ndarray", values: "np.ndarray" = None, *, weights=None) -> "np.ndarray":
    b: "np.ndarray" = basis_matrix(points)
    return (lambda: np.linalg.lstsq(b, values, rcond=None)[0])()
"""
        },
    ),
    odd(
        "an answer written twice",
        answers={
            "fit": "def fit(points, values): return 0\n\n" + RIGHT_FIT.replace("@ODD@", "pass")
        },
    ),
    odd(
        "lists for arrays",
        answers={
            "rank": """
def rank(points):
    centered = np.array(points) - np.mean(points, axis=0)
    extent = np.ptp(points, axis=0).max()
    return [[int(1 + np.linalg.matrix_rank(centered, tol=1e-9 * extent))]][0][0]
""",
            "fit": RIGHT_FIT.replace("@ODD@", "")
            .replace("return np", "return list(np")
            .replace("b.T @ values)", "b.T @ values))"),
        },
    ),
    odd(
        "a line that begins with an operator",
        answers={
            "fit": RIGHT_FIT.replace(
                "@ODD@",
                """q = (7
        % 4
        != 2)""",
            )
        },
    ),
    Case(
        "an answer to another notebook",
        number="02",
        make=lambda made: ("02 (2).ipynb", __import__("json").dumps(made).encode()),
    ),
]
