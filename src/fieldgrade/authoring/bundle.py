"""The bundle for students: notebooks, the package fieldcheck, and the requirements."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

from fieldgrade.authoring.course_map import DIAGRAM, NOTEBOOKS, PAGE
from fieldrecon._core.atomic_files import whole_file

FOLDER = "field-reconstruction"
REQUIREMENTS = "numpy>=2.1\nmatplotlib>=3.11\nipywidgets>=8.1\njupyterlab>=4.3\n"
STUDENT = "# Write your student number in the next line, as on the roster of the course.\n"
FIXED = (1980, 1, 1, 0, 0, 0)


def student_tree(root: Path) -> Iterator[tuple[str, Path]]:
    """Yield the name in the bundle and the path of each file for students."""
    for path in sorted((root / "exercises").glob("*.ipynb")):
        yield path.name, path
    package = root / "src" / "fieldcheck"
    for path in sorted(package.rglob("*")):
        if path.suffix in (".py", ".js", ".json", ".typed"):
            yield f"fieldcheck/{path.relative_to(package).as_posix()}", path
    yield "README.md", root / "docs" / "students.md"
    yield "course.md", root / PAGE
    yield f"images/{DIAGRAM.name}", root / DIAGRAM
    yield "LICENSE", root / "LICENSE"


def write_bundle(root: Path, file: Path) -> Path:
    """Write the zip file for students, and return it."""
    with (
        whole_file(file) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as bundle,
    ):
        for name, path in student_tree(root):
            _add(bundle, name, _content(path))
        _add(bundle, "requirements.txt", REQUIREMENTS.encode())
        _add(bundle, "student.txt", STUDENT.encode())
    return file


def _content(path: Path) -> bytes:
    """Return the content of a file; in the bundle the map is beside the notebooks."""
    content = path.read_bytes()
    return content.replace(f"({NOTEBOOKS}".encode(), b"(") if path.name == PAGE.name else content


def _add(bundle: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(f"{FOLDER}/{name}", date_time=FIXED)
    entry.external_attr = 0o644 << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    bundle.writestr(entry, content)
