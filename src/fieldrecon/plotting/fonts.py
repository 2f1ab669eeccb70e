"""The fonts of the report, taken from the Typst wheel.

Typst carries its default fonts uncompressed in its extension module. Figures, PDF and HTML take
them from there: all three are set in the same faces on every machine, with no system font involved.
"""

from __future__ import annotations

import shutil
import struct
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path

from fieldrecon._core.atomic_files import write_atomically

SERIF = "Libertinus Serif"
SERIF_FACES = {
    "regular": "LibertinusSerif-Regular",
    "italic": "LibertinusSerif-Italic",
    "bold": "LibertinusSerif-Bold",
}
MATH = "NewCMMath-Book"


def font_file(name: str) -> Path:
    """Path of the OpenType file of one face, written to the cache folder on the first call.

    Parameters
    ----------
    name : str
        PostScript name of the face, such as ``"LibertinusSerif-Italic"``.

    Returns
    -------
    Path

    Raises
    ------
    LookupError
        The installed Typst does not carry the face.
    """
    import matplotlib

    folder = Path(matplotlib.get_cachedir()) / f"fieldrecon-typst-{version('typst')}"
    path = folder / f"{name}.otf"
    if not path.exists():
        write_atomically(path, font_bytes(name))
    return path


def font_bytes(name: str) -> bytes:
    """Bytes of the OpenType file of one face.

    Parameters
    ----------
    name : str
        PostScript name of the face.

    Returns
    -------
    bytes

    Raises
    ------
    LookupError
        The installed Typst does not carry the face.

    Examples
    --------
    >>> font_bytes("LibertinusSerif-Regular")[:4]
    b'OTTO'
    """
    start, end = _offsets().get(name, (0, 0))
    if not end:
        raise LookupError(
            f"the font {name} is not in the Typst wheel {version('typst')} (it has "
            f"{', '.join(sorted(_offsets())) or 'none'}): install the version in requirements.lock"
        )
    with _library().open("rb") as library:
        library.seek(start)
        return library.read(end - start)


def _library() -> Path:
    import typst

    return next(p for p in Path(typst.__file__).parent.iterdir() if p.name.startswith("_typst"))


@cache
def _offsets() -> dict[str, tuple[int, int]]:
    """Offsets (start, end) of each face in the library, by PostScript name."""
    library = _library().read_bytes()
    return {name: (start, end) for name, start, end in _opentype_files(library)}


def _opentype_files(library: bytes) -> Iterator[tuple[str, int, int]]:
    """Every CFF OpenType file in the bytes, known by its magic number and its table directory."""
    start = library.find(b"OTTO")
    while start >= 0:
        tables = _table_directory(library, start)
        if b"CFF " in tables and b"name" in tables:
            offset = start + tables[b"CFF "][0]
            end = start + max(o + length for o, length in tables.values())
            yield _postscript_name(library, offset), start, end + (start - end) % 4
        start = library.find(b"OTTO", start + 4)


def _table_directory(library: bytes, start: int) -> dict[bytes, tuple[int, int]]:
    (count,) = struct.unpack_from(">H", library, start + 4)
    if not 5 <= count <= 40 or start + 12 + 16 * count > len(library):
        return {}
    records = (struct.unpack_from(">4sLLL", library, start + 12 + 16 * k) for k in range(count))
    return {tag: (offset, length) for tag, _, offset, length in records}


def _postscript_name(library: bytes, cff: int) -> str:
    """First entry of the name index of a CFF table (header, then count, offset size, offsets)."""
    header = library[cff + 2]
    size = library[cff + header + 2]
    offsets = cff + header + 3
    first = int.from_bytes(library[offsets : offsets + size])
    last = int.from_bytes(library[offsets + size : offsets + 2 * size])
    (count,) = struct.unpack_from(">H", library, cff + header)
    data = offsets + (count + 1) * size - 1
    return library[data + first : data + last].decode("latin-1")


def copy_font_list(folder: Path) -> None:
    """Copy matplotlib's list of fonts, whose creation takes most of its start-up time."""
    import matplotlib as mpl
    from matplotlib import font_manager

    _ = font_manager.fontManager  # makes the list, if there is none yet
    folder.mkdir()
    for path in Path(mpl.get_cachedir()).glob("fontlist-*.json"):
        shutil.copy(path, folder)
