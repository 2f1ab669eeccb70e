"""Answers in the blocks of `if`, `try`, `with` and loops in which a line fails."""

from textwrap import indent

from hostile.case import Case
from hostile.running import FIT, fitted

WRONG_FIT = "def fit(points, values):\n    return 0.0\n"
RIGHT, WRONG = (indent(code, "    ") for code in (FIT, WRONG_FIT))
PARTIAL = FIT.replace("def fit", "def _fit") + "fit = functools.partial(_fit)\n"
DEEP = "with np.errstate():\n  try:\n    if True:\n      undefined()\n"
NESTED = "".join(" " * depth + "if True:\n" for depth in range(90)) + " " * 90 + "undefined()\n"


def blocked(name, above, below="", answer=FIT, **more):
    """A case in which the answer stands in a block, below some lines and above others."""
    return fitted(f"block: {name}", above + indent(answer, "    ") + below, **more)


BLOCKS = [
    blocked("if", "if True:\n    import pandas_not_here", missing="pandas_not_here"),
    blocked(
        "with",
        "with open('mine.txt') as file:\n    text = file.read()",
        missing_files=("mine.txt",),
    ),
    blocked("with, below its first line", "with np.errstate(all='ignore'):\n    print(undefined)"),
    blocked(
        "with what has failed",
        "import pandas_not_here as pd\nwith pd.option_context('x'):",
        missing="pandas_not_here",
    ),
    blocked("for", "for trial in range(3):\n    print(undefined)\n    if trial: break"),
    blocked("for, of nothing known", "for trial in undefined:\n    trial += 1"),
    blocked("while", "while True:\n    print(undefined)", "    break"),
    blocked("if, of nothing known", "if undefined.version > 2:\n    print(1)"),
    blocked("elif", "if not np:\n    pass\nelif True:\n    print(undefined)"),
    blocked("match", "match np:\n  case _:\n    print(undefined)"),
    blocked("try, finally", "try:\n    print(undefined)", "finally:\n    pass"),
    blocked("try, else", "try:\n    pass\nexcept ValueError: pass\nelse:\n    print(undefined)"),
    blocked(
        "try that passes over",
        "def fit(*_):\n    raise NotImplementedError\n"
        "try:\n    import pandas_not_here\n    POWER = 1",
        "except ImportError:\n    pass\n",
        FIT.replace("return", "return POWER *"),
    ),
    blocked(
        "try whose handler fails",
        "try:\n    import pandas_not_here",
        "except ImportError:\n    print(undefined)\n",
        missing="pandas_not_here",
    ),
    blocked(
        "with that passes over",
        "import contextlib\nwith contextlib.suppress(ImportError):\n    import pandas_not_here",
    ),
    blocked("crash", "if True:\n    import os; os.abort()\n"),
    blocked("loop", "with np.errstate():\n    while True: pass", status="killed: time"),
    blocked("partial", "if True:\n    print(undefined)\n    import functools", answer=PARTIAL),
    fitted("if in try in with", f"{DEEP}{indent(FIT, '      ')}  finally: pass"),
    fitted("ninety blocks", NESTED + FIT),
    fitted("many lines of a block", "if True:\n    undefined()\n" + "    x = 1\n" * 20_000 + FIT),
    fitted(
        "a fallback in a handler",
        f"try:\n    import numba_not_here\n{WRONG}except ImportError:{RIGHT}",
    ),
    fitted(
        "a flag that says whether a module is there",
        "HAS = False\ntry:\n    import numba_not_here\n    HAS = True\nexcept ImportError: pass\n"
        f"if HAS:\n{WRONG}else:{RIGHT}",
    ),
    fitted(
        "an answer that a try would have replaced",
        f"{FIT}\ntry:\n    from numba_not_here import njit\n    @njit\n{WRONG}"
        "except ImportError: pass",
    ),
]
"""Honest answers; each runs in Jupyter where the missing module or name is there."""

NOT_REACHED = [
    Case(f"not reached: {name}", lost=("01.2",), answers={"fit": code})
    for name, code in {
        "a branch that is not taken": f"if False:{RIGHT}",
        "the other branch": f"if True:\n    undefined()\nelse:{RIGHT}",
        "a handler that is not needed": f"try:\n    pass\nexcept ValueError:{RIGHT}",
        "a loop over nothing": f"for k in ():{RIGHT}",
        "an answer that is replaced": f"if True:\n    undefined()\n{RIGHT}{WRONG}",
    }.items()
]
"""Answers that no line reaches, and one below which another stands."""
