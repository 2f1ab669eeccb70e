"""What a submission needs and does not have: modules, files beside the notebook, and fonts."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

MOST_MISSING = 20
"""Names of each kind that are reported."""
IN_ERRORS = {
    "modules": re.compile(r"ModuleNotFoundError: No module named '(?P<name>[^']+)'"),
    "files": re.compile(
        r"FileNotFoundError: (?:\[Errno 2\] No such file or directory: "
        r"(?P<quote>['\"])(?P<name>.+?)(?P=quote)(?: -> .*)?"
        r"|(?P<by_numpy>.+) not found\.)$"
    ),
    "fonts": re.compile(r"ValueError: Failed to find font :?(?:family=)?(?P<name>[^:,]+)[:,]"),
}
"""The errors that name what is missing."""
FONT_WARNING = re.compile(
    r"findfont: (?:Font family (?P<one>.+?) not found"
    r"|Generic family .+ none of the following families were found: (?P<several>.+))"
)
VALID = {
    "modules": re.compile(r"\w[\w.]{0,80}"),
    "files": re.compile(r".{1,120}"),
    "fonts": re.compile(r".{1,80}"),
}


@dataclass(frozen=True)
class Missing:
    """The names of what a submission needs and does not have.

    Parameters
    ----------
    modules : tuple of str
        Modules that are neither installed nor submitted.
    files : tuple of str
        Files and folders that are not in the folder of the notebook, as the code names them.
    fonts : tuple of str
        Fonts of figures that are not installed.
    """

    modules: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    fonts: tuple[str, ...] = ()

    def __or__(self, other: Missing) -> Missing:
        return Missing(
            *(
                tuple(dict.fromkeys((*getattr(self, kind), *getattr(other, kind))))[:MOST_MISSING]
                for kind in VALID
            )
        )

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) for field in fields(self))


NOTHING = Missing()


def in_error(text: str) -> Missing:
    """Return what an error misses, from its type and message.

    Examples
    --------
    >>> in_error("FileNotFoundError: [Errno 2] No such file or directory: 'data.csv'").files
    ('data.csv',)
    >>> in_error("FileNotFoundError: data.csv not found."), in_error("KeyError: 'x'").files
    (Missing(modules=(), files=('data.csv',), fonts=()), ())
    """
    found = ((kind, pattern.match(text)) for kind, pattern in IN_ERRORS.items())
    return validated({k: [m["name"] or m[m.lastindex or 0]] for k, m in found if m})


def validated(data: Any) -> Missing:
    """Return the valid names in data that may come from the sandbox."""
    found = data if isinstance(data, Mapping) else {}
    return Missing(**{kind: tuple(_valid(kind, found.get(kind))) for kind in VALID})


def _valid(kind: str, names: object) -> Iterator[str]:
    for name in names[:MOST_MISSING] if isinstance(names, list) else ():
        if isinstance(name, str) and VALID[kind].fullmatch(name) and name.isprintable():
            yield name


class FontWarnings(logging.Handler):
    """Notes the fonts that matplotlib does not find when it draws."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[str, None] = {}
        logging.getLogger("matplotlib.font_manager").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Note the fonts in a warning."""
        if warning := FONT_WARNING.match(record.getMessage()):
            self.found |= dict.fromkeys(_names(warning["one"] or warning["several"]))

    def take(self) -> Missing:
        """Return the fonts that were missing since the last call."""
        found, self.found = [*self.found], {}
        return validated({"fonts": found})


def _names(text: str) -> Iterable[str]:
    return (part.strip(" []'\"") for part in text.split(","))
