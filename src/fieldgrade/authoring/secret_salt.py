"""The secret salt, from which the grader draws hidden inputs."""

from __future__ import annotations

import json
import secrets
import subprocess
from dataclasses import dataclass
from pathlib import Path

from fieldcheck.seeds import PUBLIC_SALT

FILE = ".course-secret.json"
MISSING = (
    "There is no secret salt, so students can compute the inputs of the graders. "
    "Create it with: fieldrecon course init"
)


@dataclass(frozen=True)
class Salt:
    """A salt and its year; without a secret salt, the public one."""

    text: str
    year: int = 0

    @property
    def secret(self) -> bool:
        """Whether the salt is unknown to students."""
        return self.text != PUBLIC_SALT


def read_salt(folder: Path) -> Salt:
    """Return the secret salt of a folder, or the public one.

    Raises
    ------
    ValueError
        git tracks the file, or it is damaged.
    """
    file = folder / FILE
    if not file.is_file():
        return Salt(PUBLIC_SALT)
    _require_untracked(file)
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
        return Salt(str(data["salt"]), int(data["year"]))
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{FILE} is damaged: remove it, and create another with init") from error


def make_salt(folder: Path, year: int, renew: bool = False) -> Salt:
    """Write a new secret salt for a year, readable by its owner only, and return it.

    Raises
    ------
    ValueError
        git tracks the file or does not ignore it, or it exists and `renew` is false.
    """
    file = folder / FILE
    _require_untracked(file)
    if file.exists() and not renew:
        raise ValueError(
            f"{FILE} exists, for {read_salt(folder).year}; with --renew it is replaced, and the "
            "inputs of all students change"
        )
    salt = Salt(secrets.token_hex(16), year)
    file.unlink(missing_ok=True)
    file.touch(mode=0o600)
    file.write_text(json.dumps({"salt": salt.text, "year": salt.year}) + "\n", encoding="utf-8")
    return salt


def _require_untracked(file: Path) -> None:
    """Refuse a file that git tracks or does not ignore."""
    if _git(file.parent, "rev-parse", "--is-inside-work-tree"):
        return
    if _git(file.parent, "ls-files", "--error-unmatch", file.name) == 0:
        raise ValueError(
            f"git tracks {file.name}, so it is not secret: remove it from git, and renew it"
        )
    if _git(file.parent, "check-ignore", "--quiet", file.name) != 0:
        raise ValueError(f"git does not ignore {file.name}: add it to .gitignore first")


def _git(folder: Path, *arguments: str) -> int:
    """Return the exit status of git; 127 if git is not installed."""
    try:
        return subprocess.run(
            ("git", *arguments), cwd=folder, capture_output=True, check=False
        ).returncode
    except FileNotFoundError:
        return 127
