"""Public names of the package: resolved on use, and not imported earlier."""

import subprocess
import sys
from importlib.util import find_spec
from types import ModuleType

import pytest

import fieldrecon
from fieldrecon import _public


def test_the_package_has_the_public_names_and_tells_them():
    """Each is the object that its module defines, and ``dir`` lists it."""
    assert fieldrecon.__all__ == _public.__all__
    assert set(dir(fieldrecon)) >= set(_public.__all__)
    for name in _public.__all__:
        assert getattr(fieldrecon, name) is getattr(_public, name), name


def test_no_module_has_the_name_of_a_public_object():
    """An import of that module would put it in the place of the object."""
    objects = [n for n in _public.__all__ if not isinstance(getattr(_public, n), ModuleType)]
    assert [name for name in objects if find_spec(f"fieldrecon.{name}")] == []
    assert find_spec("fieldrecon.methods.globe"), "else the line above finds nothing"


def test_an_unknown_name_is_an_attribute_error():
    """As of any module."""
    with pytest.raises(AttributeError, match="module 'fieldrecon' has no attribute 'kriging'"):
        fieldrecon.kriging  # noqa: B018


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["experiments", "list"]])
def test_the_command_line_answers_without_numpy(arguments):
    """What computes nothing does not wait for the import of what computes."""
    code = (
        "import sys\nfrom fieldrecon.cli.main import main\n"
        f"try:\n    main({arguments})\nexcept SystemExit:\n    pass\n"
        "print([name for name in ('numpy', 'scipy', 'matplotlib') if name in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.endswith("\n[]\n")
    assert len(shown.stdout) > len("\n[]\n")
