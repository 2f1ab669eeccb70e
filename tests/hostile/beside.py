"""Data files beside a notebook, submitted or not, and fonts of figures."""

import io
import json

import numpy as np

from hostile.case import SANDBOXED, Case
from hostile.running import FIT, case, fitted

CSV = "x,y\n1,2\n3,4\n"


def npy(array):
    """An array as a file of NumPy."""
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


SCALED = FIT.replace("return ", "return data[0, 0] * ")

SUBMITTED = [
    fitted(
        "beside: a table",
        f"data = np.loadtxt('data.csv', delimiter=',', skiprows=1){SCALED}",
        helpers={"data.csv": CSV},
    ),
    fitted(
        "beside: files of many kinds, in folders",
        "import json\nfrom pathlib import Path\ndata = np.load('in/x.npy')\n"
        "assert json.loads(Path('in/deep/a.json').read_text()) == {'cells': []}\n"
        "assert sorted(p.name for p in Path('in').iterdir()) == ['deep', 'x.npy']\n"
        f"assert np.genfromtxt('numpy/with blank.txt').tolist() == [1.0, 2.0]{SCALED}",
        helpers={
            "in/x.npy": npy(np.ones((1, 1))),
            "in/deep/a.json": json.dumps({"cells": []}),
            "numpy/with blank.txt": "1\n2\n",
            "ü/é": "",
        },
    ),
    fitted(
        "beside: a table that is read in each call",
        FIT.replace("    b", "    one = np.loadtxt('one.txt')\n    b", 1).replace(
            "return", "return one *"
        ),
        helpers={"one.txt": "1"},
    ),
    fitted(
        "beside: a table read by a helper file",
        "from helper import fit",
        helpers={
            "one.txt": "1",
            "helper.py": "import numpy as np\nONE = np.loadtxt('one.txt')\n"
            f"def basis_matrix(p): return np.hstack([np.ones((len(p), 1)), p])\n{FIT}",
        },
    ),
    Case(
        "beside: names that lead out",
        tiers=SANDBOXED,
        helpers={"../up.csv": "", "/tmp/up.csv": "", "a/../../up.csv": "", "\n": "", "x" * 300: ""},
        before="import os\nassert 'up.csv' not in os.listdir('..')",
    ),
]

READ = "data = np.loadtxt('wind/data.csv')"
NOT_SUBMITTED = [
    fitted(
        "no file: read above an answer",
        f"{READ}\nmean = data.mean(){FIT}",
        missing_files=("wind/data.csv",),
    ),
    case(
        "no file: read in many ways",
        before="def tried(read, name):\n    try:\n        read(name)\n"
        "    except FileNotFoundError as error:\n        missing.append(error)\n"
        "missing = []\nfrom matplotlib import pyplot as plt\n"
        "for read in (open, np.load, np.genfromtxt, np.fromfile, plt.imread):\n"
        "    tried(read, f'{read.__name__}.x')\n"
        "raise missing[0]\n",
        after="raise missing[1]\nraise missing[2]",
        missing_files=("open.x", "load.x"),
    ),
    Case(
        "no file: an answer of it",
        lost=("01.2",),
        answers={"fit": f"{READ}{SCALED}"},
        missing_files=("wind/data.csv",),
    ),
    Case(
        "no file: read in an answer",
        lost=("01.2",),
        answers={"fit": f"def fit(points, values):\n    {READ}\n    return data"},
        missing_files=("wind/data.csv",),
    ),
    case(
        "no file: an end in the handler",
        before="try:\n    open('mine.csv')\nexcept OSError:\n    raise SystemExit('no') from None",
        missing_files=("mine.csv",),
    ),
    case(
        "no file: a thousand",
        before="".join(f"open('{k:03}')\n" for k in range(1000)),
        missing_files=tuple(f"{k:03}" for k in range(20)),
    ),
    case(
        "no file: a name that is none",
        before="open('x' * 130)\nopen('a\\nb')\nraise FileNotFoundError",
        missing_files=("a\\nb",),
    ),
]

DRAWN = (
    "from matplotlib import pyplot as plt\nplt.title('x', fontfamily='{}')\nplt.savefig('x.png')\n"
)
FONTS = [
    case(
        "font: another family",
        before=DRAWN.format("Not Here Sans"),
        missing_fonts=("Not Here Sans",),
    ),
    case(
        "font: the setting of all figures",
        before="from matplotlib import pyplot as plt\nplt.rcParams['font.family'] = 'serif'\n"
        "plt.rcParams['font.serif'] = ['Not Here', 'Nor Here']\n"
        "plt.plot([1, 2])\nplt.tight_layout()",
        missing_fonts=("Not Here", "Nor Here"),
    ),
    case(
        "font: one of several is there",
        before="from matplotlib import pyplot as plt\nplt.rcParams['font.family'] = 'serif'\n"
        "plt.rcParams['font.serif'] = ['Not Here', 'DejaVu Serif']\n"
        "plt.title('x')\nplt.tight_layout()",
    ),
    fitted(
        "font: an error",
        "from matplotlib import font_manager\n"
        f"font_manager.findfont('Not Here', fallback_to_default=False){FIT}",
        missing_fonts=("Not Here",),
    ),
    fitted(
        "font: a file",
        "from matplotlib import pyplot as plt\n"
        "plt.title('x', fontproperties={'fname': 'here.ttf'})\nplt.savefig('x.png')" + FIT,
        missing_files=("here.ttf",),
    ),
    case(
        "font: many forged warnings",
        before="import logging\nfor k in range(999):\n"
        "    logging.getLogger('matplotlib.font_manager').warning(\n"
        "        'findfont: Font family %s not found.', f'<b>{k:03}' + 'x' * (90 * (k > 30)))\n"
        "logging.getLogger('matplotlib.font_manager').warning('findfont: %d', 'x')",
        missing_fonts=tuple(f"<b>{k:03}" for k in range(20)),
    ),
]
