"""Submissions as students and learning platforms make them: notebooks, scripts and zip files."""

import io
import json
import zipfile

FUNCTIONS = {"01": ["fit", "rank", "gradient"], "02": ["weights", "field", "gradient"]}
"""The functions of two notebooks; both have a function `gradient`."""
ANSWER = "def fit(points, values):\n    return values\n"
STUB = 'def fit(points, values):\n    raise NotImplementedError("01.2 is not written yet")\n'


def code(source, **more):
    return {"cell_type": "code", "metadata": {}, "outputs": [], "source": source} | more


def prose(source, **more):
    return {"cell_type": "markdown", "metadata": {}, "source": source} | more


def notebook(*cells, **metadata):
    """The bytes of a notebook with these cells; a string is a code cell."""
    made = [code(cell) if isinstance(cell, str) else cell for cell in cells]
    data = {"cells": made, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(data).encode()


def of_format_3(*cells):
    old = [{"cell_type": "code", "input": cell, "language": "python"} for cell in cells]
    return json.dumps({"nbformat": 3, "worksheets": [{"cells": old}]}).encode()


def packed(files):
    """The bytes of a zip file; a name may be a ZipInfo."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as pack:
        for name, content in files.items() if isinstance(files, dict) else files:
            pack.writestr(name, content)
    return stream.getvalue()


def write_files(folder, files):
    """Write files with these names and contents below a folder."""
    for name, content in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    return folder
