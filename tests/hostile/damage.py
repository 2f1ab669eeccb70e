"""Damaged and unusual files: readable files are graded, and others are reported."""

import json

from hostile.case import EVERYTHING, Case, as_file, code_cell, stub


def text(made, **more):
    """The bytes of a notebook."""
    return json.dumps(made, **more).encode()


def file(name, make, lost=(), **more):
    """A case given by a file."""
    return Case(name, make=make, lost=lost, **more)


def unreadable(name, make, notes):
    """A case given by a file that is not a notebook."""
    return Case(name, make=make, lost=EVERYTHING, status="unreadable", notes=notes)


def changed(change):
    """A function that changes the data of a notebook."""

    def make(made):
        change(made)
        return as_file(made)

    return make


def format_3(made):
    """The notebook in the notebook format 3 of 2012."""
    cells = [
        {
            "cell_type": "code",
            "language": "python",
            "input": c["source"],
            "outputs": [],
            "collapsed": False,
            "metadata": {},
        }
        if c["cell_type"] == "code"
        else c
        for c in made["cells"]
    ]
    old = {"nbformat": 3, "nbformat_minor": 0, "metadata": {"name": ""}}
    return "01.ipynb", text(old | {"worksheets": [{"cells": cells, "metadata": {}}]})


def bare(made):
    """The notebook with cell types and sources only."""
    kept = ("cell_type", "source")
    return "01.ipynb", text({"cells": [{k: c[k] for k in kept} for c in made["cells"]]})


def script(made, begin="# %%", end="\n"):
    """The notebook as a script as written by editors and nbconvert."""
    cells = [c["source"] for c in made["cells"] if c["cell_type"] == "code"]
    return "01.py", end.join(f"{begin}\n{c}\n" for c in cells).replace("\n", end).encode()


def exported(made):
    """The notebook as exported by nbconvert, with magic commands."""
    for cell in made["cells"]:
        if cell["source"].startswith("import numpy"):
            magic = "get_ipython().run_line_magic('matplotlib', 'inline')\n"
            cell["source"] = magic + "get_ipython().system('ls')\n" + cell["source"]
    return script(made, "# In[1]:\n\n")


def same_ids(made):
    """All cells with the same id, and one cell twice."""
    for cell in made["cells"]:
        cell["id"] = "q-01-1"
    made["cells"].insert(5, made["cells"][4])


def only_answers(made):
    """The imports and the answers only."""
    kept = [c for c in made["cells"] if c["source"].startswith(("def ", "import"))]
    made["cells"] = [{k: v for k, v in c.items() if k != "id"} for c in kept]


def kernelspec(made):
    """A kernel that exists only on the machine of the student."""
    made["metadata"] = {
        "kernelspec": {"name": "conda-env-mine-py", "language": "julia"},
        "language_info": {"name": "julia", "version": "1.9"},
    }


def huge(made):
    """A notebook with ten megabytes of pictures."""
    for cell in made["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"] = [
                {
                    "output_type": "display_data",
                    "metadata": {},
                    "data": {"image/png": "A" * 400_000},
                }
            ]


def large(name, value):
    """A function that adds a value to each code cell and to the metadata."""

    def change(made):
        for cell in made["cells"]:
            if cell["cell_type"] == "code":
                cell[name] = value
        made["metadata"][name] = value

    return changed(change)


def attached(made):
    """A text with a picture, as Jupyter stores one that is dragged into a cell."""
    picture = {"x.png": {"image/png": "A" * 30_000_000}}
    made["cells"].append({"cell_type": "markdown", "source": "", "attachments": picture})


def nested(levels):
    """Arrays in arrays."""
    inner = []
    for _ in range(levels - 1):
        inner = [inner]
    return inner


def odd_cells(made):
    """Invalid cells among the valid ones."""
    made["cells"][3:3] = [
        None,
        7,
        "cell",
        {},
        {"cell_type": "code"},
        {"cell_type": ["code"]},
        {"cell_type": "code", "source": {"a": 1}},
    ]
    made["cells"].append({"cell_type": "code", "source": ["x = 1\n", 7, None, "y = 2"]})


def stale(made):
    """A stub after a right answer."""
    made["cells"].append(code_cell(stub("fit")))


def one_is_missing(made):
    """A question whose cell was deleted."""
    made["cells"] = [c for c in made["cells"] if "def objective" not in c["source"]]


def with_cell(code):
    """A notebook with an additional cell."""
    return changed(lambda made: made["cells"].append(code_cell(code)))


CASES = [
    unreadable(
        "a file cut off in the middle", lambda made: ("01.ipynb", as_file(made)[1][:9000]), "broken"
    ),
    unreadable("an empty file", lambda _: ("01.ipynb", b""), "empty"),
    unreadable("zeros", lambda _: ("01.ipynb", bytes(4096)), "no"),
    unreadable("JSON that is no notebook", lambda _: ("01.ipynb", b"[]"), "not a notebook"),
    unreadable("a notebook with null for cells", lambda _: ("01.ipynb", b'{"cells": null}'), "no"),
    unreadable("JSON a million deep", lambda _: ("01.ipynb", b'{"cells":' + b"[" * 10**6), "no"),
    unreadable(
        "a picture called a notebook",
        lambda _: ("01.ipynb", b"\x89PNG\r\n\x1a\n" + bytes(range(256))),
        "is not text",
    ),
    unreadable("metadata nested 900 levels deep", large("x", nested(900)), "50 levels deep"),
    unreadable("a notebook nested 100 levels deep", large("x", nested(100)), "50 levels deep"),
    unreadable(
        "notebooks in notebooks",
        lambda _: ("01.ipynb", b'{"cells":' * 200 + b"1" + b"}" * 200),
        "50 levels deep",
    ),
    unreadable(
        "a hundred thousand names",
        lambda _: ("01.ipynb", b"{" + b",".join(b'"%d":{}' % k for k in range(110_000)) + b"}"),
        "more than 300000 elements",
    ),
    unreadable(
        "a number of 5000 digits in the metadata",
        lambda made: ("01.ipynb", text(made | {"x": "@"}).replace(b'"@"', b"7" * 5000)),
        "broken",
    ),
    unreadable(
        "twenty megabytes of empty objects",
        lambda _: ("01.ipynb", b'{"cells": [' + b"{}," * (6 << 20) + b"{}]}"),
        "more than 300000 elements",
    ),
    unreadable("a page of HTML", lambda _: ("01.ipynb", b"<!DOCTYPE html><html></html>"), "no"),
    unreadable(
        "a notebook of something else",
        lambda _: ("01.ipynb", text({"cells": [code_cell("x = 1")]})),
        "none of",
    ),
    file("without metadata", bare),
    file("the format of 2012", format_3),
    file("duplicate ids", changed(same_ids)),
    file("nothing but the answers", changed(only_answers)),
    file("a kernel that is not here", changed(kernelspec)),
    file("cells that are none", changed(odd_cells)),
    file("a script with cells", script),
    file("a script as nbconvert exports it", exported),
    file("a script with the ends of lines of Windows", lambda made: script(made, end="\r\n")),
    file("renamed", lambda made: ("ps1 (1) FINAL — копия.ipynb", as_file(made)[1])),
    file("a byte order mark", lambda made: ("01.ipynb", b"\xef\xbb\xbf" + as_file(made)[1])),
    file(
        "the ends of lines of Windows",
        lambda made: ("01.ipynb", as_file(made)[1].replace(b"\n", b"\r\n")),
    ),
    file("UTF-16", lambda made: ("01.ipynb", as_file(made)[1].decode().encode("utf-16"))),
    file("pictures of ten megabytes", changed(huge)),
    file("thirty megabytes of printed text", large("outputs", [{"text": ["0.12345\n"] * 100_000}])),
    file("thirty megabytes of one picture", large("outputs", [{"image/png": "A" * 1_500_000}])),
    file(
        "numbers that are not numbers", changed(lambda made: made.update(x=[float("nan"), 9e999]))
    ),
    file("cells given twice", lambda made: ("01.ipynb", b'{"cells": [], ' + as_file(made)[1][1:])),
    file("thirty megabytes of a picture in a text", changed(attached)),
    file("fifty megabytes of tables", large("outputs", [{"text/html": '"\\]}\u2028' * 170_000}])),
    file("outputs nested 900 levels deep", large("outputs", nested(900))),
    file("the state of many widgets", large("widgets", {"state": [{}] * 250_000})),
    file("a stub after an answer", changed(stale), notes="stub"),
    file("an answer deleted", changed(one_is_missing), lost=("01.6",)),
    file("a hundred thousand brackets", with_cell("(" * 10**5 + "1" + ")" * 10**5)),
    file("a million signs", with_cell("-" * 10**6 + "1")),
    file("a sum of a hundred thousand", with_cell("1" + "+1" * 10**5)),
    file("calls of calls of calls", with_cell("f" + "()" * 10**5)),
    file(
        "blocks a hundred deep",
        with_cell("\n".join(" " * k + "if 1:" for k in range(120)) + " pass"),
    ),
    file("a number of a million digits", with_cell("x = " + "9" * 10**6)),
    unreadable(
        "a line of ten million letters",
        with_cell("x = '" + "x" * 10**7 + "'"),
        "more than 1 MiB of code",
    ),
    file(
        "lone surrogates and zeros in the code",
        changed(lambda made: made["cells"].append(code_cell("x = '\udc80\\0'\n\x00"))),
    ),
]
