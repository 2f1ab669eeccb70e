"""Optional packages: which extra of fieldrecon brings a missing one, and the line that installs it.

The metadata of the installed distribution say which package belongs to which extra, and from where
fieldrecon itself was installed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import urlsplit

DISTRIBUTION = "fieldrecon"
PICTURES = ("matplotlib", "typst")
"""What a picture takes: the fonts are those that typst carries."""
_PROVIDER = {
    "IPython": "ipykernel",
    "mpl_toolkits": "matplotlib",
    "pypandoc": "pypandoc_binary",
    "skimage": "scikit-image",
}
"""Packages of another name than the module that is imported."""


def optional(module: str) -> ModuleType:
    """Import a module that comes with an extra.

    Raises
    ------
    ModuleNotFoundError
        If it is not installed: the message names the extra, and the line that installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(remedy(error.name or module)) from None


def require(*modules: str) -> None:
    """Refuse to begin what would fail later for want of a package.

    Raises
    ------
    ModuleNotFoundError
        Naming all of them that are missing, their extras, and one line that installs them.
    """
    if missing := absent(*modules):
        raise ModuleNotFoundError(remedy(*missing))


def absent(*modules: str) -> list[str]:
    """Return those of the modules that are not installed."""
    return [module for module in modules if find_spec(module) is None]


def remedy(*modules: str) -> str:
    """Return the sentence for missing modules: their packages, their extras, and the line to type.

    Parameters
    ----------
    *modules : str
        Names as they are imported; of submodules, the first part counts.
    """
    packages = list(dict.fromkeys(map(_package, modules)))
    known = dict(_extras())
    extras = list(dict.fromkeys(known[_key(p)] for p in packages if _key(p) in known))
    one = len(packages) == 1
    sentence = f"{_listed(packages)} {'is' if one else 'are'} not installed"
    if not extras:
        return sentence
    names = _listed([f"'{extra}'" for extra in extras])
    brought = f"{'it comes' if one else 'they come'} with the extra{'s' * (len(extras) > 1)}"
    return f"{sentence}; {brought} {names}: {_command(extras)}"


def _package(module: str) -> str:
    name = module.partition(".")[0]
    return _PROVIDER.get(name, name)


def _key(package: str) -> str:
    """The name by which indices know a package, in one of the spellings that they take as equal."""
    return re.sub(r"[-_.]+", "-", package).lower()


def _extras() -> Iterator[tuple[str, str]]:
    """Yield packages with an extra that requires them; the last one of a package is the first."""
    for requirement in reversed(_installed().requires or []):
        package = re.match(r"[\w.-]+", requirement)
        extra = re.search(r"""extra\s*==\s*["']([\w.-]+)["']""", requirement)
        if package and extra:
            yield _key(package[0]), extra[1]


def _installed() -> Distribution:
    """Return the distribution that an installer recorded, not what a build left beside the source.

    Builds leave a folder src/fieldrecon.egg-info, which counts wherever src is on the path.
    """
    found = list(distributions(name=DISTRIBUTION))
    return next((d for d in found if d.read_text("RECORD") is not None), found[0])


def _command(extras: list[str]) -> str:
    """Return the line that installs the extras from where fieldrecon was installed.

    Nothing but the record that installers leave (PEP 610) tells an index from a folder or a file.
    """
    record = _installed().read_text("direct_url.json")
    wanted = ",".join(extras)
    if record is None:
        return f"pip install '{DISTRIBUTION}[{wanted}]'"
    origin = json.loads(record)
    if urlsplit(origin["url"]).scheme != "file":
        return f"pip install '{DISTRIBUTION}[{wanted}] @ {_locator(origin)}'"
    from urllib.request import url2pathname  # which imports much that nothing else needs

    path = Path(url2pathname(urlsplit(origin["url"]).path))
    place = "." if path.resolve() == Path.cwd() else path
    editable = "--editable " if origin.get("dir_info", {}).get("editable") else ""
    return f"pip install {editable}'{place}[{wanted}]'"


def _locator(origin: dict[str, Any]) -> str:
    control = origin.get("vcs_info")
    return f"{control['vcs']}+{origin['url']}@{control['commit_id']}" if control else origin["url"]


def _listed(names: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
