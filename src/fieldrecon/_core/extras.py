"""Optional packages: the extra that provides a missing one, and the command that installs it.

The metadata of the installed distribution say which package belongs to which extra, and from where
fieldrecon itself was installed.
"""

from __future__ import annotations

import json
import re
from importlib import import_module
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import urlsplit

LIBRARY = "fieldrecon"
COMPANION = "fieldrecon-course"
"""The distribution of the report and the course, from the folder src of the same checkout."""
PICTURES = ("matplotlib", "typst")
"""Packages needed for pictures; the fonts come with typst."""
_PROVIDER = {
    "IPython": "ipykernel",
    "PIL": "pillow",
    "mpl_toolkits": "matplotlib",
    "pypandoc": "pypandoc_binary",
    "skimage": "scikit-image",
}
"""Packages whose name differs from that of the imported module."""


def optional(module: str) -> ModuleType:
    """Import a module that comes with an extra.

    Raises
    ------
    ModuleNotFoundError
        If it is not installed: the message names the extra, and the command that installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(remedy(error.name or module)) from None


def require(*modules: str) -> None:
    """Refuse to begin work that would fail later for lack of a package.

    Raises
    ------
    ModuleNotFoundError
        Naming all missing packages, their extras, and the command that installs them.
    """
    if missing := absent(*modules):
        raise ModuleNotFoundError(remedy(*missing))


def absent(*modules: str) -> list[str]:
    """Return the modules that are not installed."""
    return [module for module in modules if find_spec(module) is None]


def remedy(*modules: str) -> str:
    """Return the sentence for missing modules: their packages, extras, and the command to type.

    Parameters
    ----------
    *modules : str
        Names as they are imported; only the first part of a submodule's name counts.
    """
    packages = list(dict.fromkeys(map(_package, modules)))
    distribution, extras = _richest(packages)
    one = len(packages) == 1
    sentence = f"{_listed(packages)} {'is' if one else 'are'} not installed"
    if not extras:
        return sentence
    names = _listed([f"'{extra}'" for extra in extras])
    brought = f"{'it comes' if one else 'they come'} with the extra{'s' * (len(extras) > 1)}"
    return f"{sentence}; {brought} {names}: {_command(distribution, extras)}"


def companion(extra: str) -> str:
    """Name the distribution of the report and the course, and the line that installs it."""
    library = _installed(LIBRARY)
    assert library, "the running code has metadata"
    folder = _folder(library)
    if folder and (folder / "src" / "pyproject.toml").is_file():
        return f"{COMPANION}: pip install '{_shown(folder / 'src')}[{extra}]'"
    return f"{COMPANION}: pip install '{COMPANION}[{extra}]'"


def _richest(packages: list[str]) -> tuple[Distribution, list[str]]:
    """Return the distribution whose extras have most of the packages, and these extras."""
    installed = [d for d in (_installed(LIBRARY), _installed(COMPANION)) if d]
    extras = [
        [known[_key(p)] for p in packages if _key(p) in known] for known in map(_extras, installed)
    ]
    most = max(range(len(installed)), key=lambda k: len(extras[k]))
    return installed[most], list(dict.fromkeys(extras[most]))


def _package(module: str) -> str:
    name = module.partition(".")[0]
    return _PROVIDER.get(name, name)


def _key(package: str) -> str:
    """The name by which indices know a package, in one of the spellings that they take as equal."""
    return re.sub(r"[-_.]+", "-", package).lower()


def _extras(distribution: Distribution) -> dict[str, str]:
    """Return an extra for each package that some extra requires; the first one counts."""
    found = {}
    for requirement in reversed(distribution.requires or []):
        package = re.match(r"[\w.-]+", requirement)
        extra = re.search(r"""extra\s*==\s*["']([\w.-]+)["']""", requirement)
        if package and extra:
            found[_key(package[0])] = extra[1]
    return found


def _installed(name: str) -> Distribution | None:
    """Return the distribution that an installer recorded, not one that a build left in the source.

    Builds leave a folder such as src/fieldrecon.egg-info, which counts wherever src is on the path.
    """
    found = list(distributions(name=name))
    recorded = [d for d in found if d.read_text("RECORD") is not None]
    return next(iter(recorded + found), None)


def _command(distribution: Distribution, extras: list[str]) -> str:
    """Return the line that installs the extras from where the distribution was installed."""
    wanted = ",".join(extras)
    origin = _origin(distribution)
    folder = _folder(distribution)
    if not origin:
        return f"pip install '{distribution.name}[{wanted}]'"
    if not folder:
        return f"pip install '{distribution.name}[{wanted}] @ {_locator(origin)}'"
    editable = "--editable " if origin.get("dir_info", {}).get("editable") else ""
    return f"pip install {editable}'{_shown(folder)}[{wanted}]'"


def _origin(distribution: Distribution) -> dict[str, Any]:
    """Return the record that installers leave of a folder, file or address (PEP 610), if any."""
    return dict(json.loads(distribution.read_text("direct_url.json") or "{}"))


def _folder(distribution: Distribution) -> Path | None:
    """Return the folder or file that the distribution was installed from, if that is known."""
    url = _origin(distribution).get("url", "")
    if urlsplit(url).scheme != "file":
        return None
    from urllib.request import url2pathname  # imported here, since it imports many modules

    return Path(url2pathname(urlsplit(url).path))


def _shown(path: Path) -> str:
    """Return a path as pip reads it, relative to the current folder if it lies there."""
    path, here = path.resolve(), Path.cwd()
    if path == here:
        return "."
    return f"./{path.relative_to(here)}" if path.is_relative_to(here) else str(path)


def _locator(origin: dict[str, Any]) -> str:
    control = origin.get("vcs_info")
    return f"{control['vcs']}+{origin['url']}@{control['commit_id']}" if control else origin["url"]


def _listed(names: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
