"""The set-up of a bare machine, tested on simulated machines.

Nothing is downloaded except in one slow test. A machine is a folder that is the whole PATH. Its
Pythons are the present Python behind a mask that changes the version or hides ensurepip; pip and
uv are stand-ins that record their arguments.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from checkout import ROOT

TOOLS = ["cat", "dirname", "find", "ln", "make", "mkdir", "readlink", "rm", "sh", "sleep", "touch"]
LOCKS = sorted(ROOT.glob("requirements*.lock"))

MASK = """
import os, runpy, sys
if sys.argv[1] not in ("-c", "-m"):
    os.execv(sys.executable, [sys.executable, *sys.argv[1:]])
_, what, *sys.argv[1:] = sys.argv[1:]
MASK
if sys.orig_argv[2] == "-c":
    exec(what)
elif what == "pip":
    if sys.argv[1] != "--python":
        sys.exit("this pip is not in an environment")
    if sys.argv[3] != "--version":
        runpy.run_path("STAND_INS/pip.py")
elif what == "venv" and "--without-pip" not in sys.argv:
    import venv
    venv.main(["--without-pip", *sys.argv[1:]])
    sys.argv = ["give", sys.argv[1], "pip"]
    runpy.run_path("STAND_INS/give.py")
else:
    runpy.run_module(what, run_name="__main__", alter_sys=True)
"""
RECORD = """
import sys
with open("STAND_INS/record", "a") as file:
    print("NAME", *sys.argv[1:], file=file)
"""
PIP = """
from pathlib import Path
import runpy, sys
if sys.argv[1] == "--python":
    sys.argv = ["give", Path(sys.argv[2]).parents[1], "uv"]
else:
    sys.argv = ["give", sys.prefix, "uv"]
runpy.run_path("STAND_INS/give.py")
"""
GIVE = """
import shutil, sys
from pathlib import Path
environment, name = sys.argv[1:]
package = next(Path(environment).glob("lib/python*/site-packages")) / name
package.mkdir()
shutil.copy("STAND_INS/NAME.py".replace("NAME", name), package / "__main__.py")
"""
OLD = "sys.version_info = (3, 9, 18, 'final', 0)"
BARE = "sys.modules['ensurepip'] = None"
PIPLESS = f"{BARE}\nif what == 'pip': sys.exit(1)"


class Machine:
    """A bare machine with a checkout of the project, in a folder with a space in its name."""

    def __init__(self, folder: Path):
        self.checkout = folder / "the checkout"
        self.bin = folder / "bin"
        self.stand_ins = folder / "stand-ins"
        for place in (self.checkout / "tools", self.checkout / "src", self.bin, self.stand_ins):
            place.mkdir(parents=True)
        for file in (*LOCKS, ROOT / "Makefile", ROOT / "pyproject.toml"):
            shutil.copy(file, self.checkout)
        for name in ("tools/setup.sh", "src/pyproject.toml"):
            shutil.copy(ROOT / name, self.checkout / name)
        for tool in TOOLS:
            (self.bin / tool).symlink_to(shutil.which(tool))
        self.stand_in("pip.py", RECORD.replace("NAME", "pip") + PIP)
        self.stand_in("uv.py", RECORD.replace("NAME", "uv"))
        self.stand_in("give.py", GIVE)

    def stand_in(self, name: str, text: str) -> Path:
        path = self.stand_ins / name
        path.write_text(text.replace("STAND_INS", str(self.stand_ins)))
        return path

    def command(self, name: str, body: str) -> None:
        path = self.bin / name
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)

    def python(self, name: str, mask: str = "") -> None:
        """Put a Python on the PATH."""
        script = self.stand_in(f"{name}-mask.py", MASK.replace("MASK", mask))
        self.command(name, f'exec "{sys.executable}" "{script}" "$@"')

    def make(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        environment = {"PATH": str(self.bin), "HOME": str(self.checkout.parent)}
        command = [str(self.bin / "make"), *(arguments or (".venv/ready",))]
        return subprocess.run(
            command, cwd=self.checkout, env=environment, capture_output=True, text=True
        )

    def set_up(self, *arguments: str) -> list[str]:
        """Make the environment, and return the recorded calls of pip and uv."""
        result = self.make(*arguments)
        assert result.returncode == 0, result.stderr
        record = self.stand_ins / "record"
        lines = record.read_text().splitlines() if record.exists() else []
        record.unlink(missing_ok=True)
        return lines

    def refusal(self, *arguments: str) -> str:
        """Fail to make the environment, and return the sentence with the reason."""
        result = self.make(*arguments)
        assert result.returncode != 0
        sentences = [s for s in result.stderr.splitlines() if s.startswith("fieldrecon: ")]
        assert len(sentences) == 1, result.stderr
        return sentences[0].removeprefix("fieldrecon: ")


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


def test_pip_installs_uv_and_uv_installs_everything_else(machine):
    """Every package is pinned by hash; the project itself is installed without dependencies."""
    machine.python("python3")
    bring_uv, packages, project = machine.set_up()
    assert re.match(r"pip install .*--require-hashes -r requirements-setup\.lock$", bring_uv)
    assert re.match(r"uv pip install .*--require-hashes .*-r requirements\.lock$", packages)
    assert re.match(
        r"uv pip install .*--no-deps --no-build-isolation .*--editable \. --editable \./src$",
        project,
    )


def test_a_second_set_up_does_nothing(machine):
    machine.python("python3")
    machine.set_up()
    for name in ("python3", "sh"):
        (machine.bin / name).unlink()
    assert machine.set_up() == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["requirements.lock", "pyproject.toml"])
def test_a_changed_lock_file_updates_the_existing_environment(machine, name):
    """The environment is not made anew."""
    machine.python("python3")
    machine.set_up()
    (machine.checkout / ".venv" / "mine").touch()
    os.utime(machine.checkout / name, (2**31, 2**31))
    assert [line.split()[0] for line in machine.set_up()] == ["uv", "uv"]
    assert (machine.checkout / ".venv" / "mine").exists()


def remove_the_stamp(checkout):
    (checkout / ".venv" / "ready").unlink()


def leave_an_empty_folder(checkout):
    shutil.rmtree(checkout / ".venv")
    (checkout / ".venv").mkdir()


def lose_the_interpreter(checkout):
    (checkout / ".venv" / "bin" / "python").unlink()


def leave_the_lock_of_a_dead_process(checkout):
    remove_the_stamp(checkout)
    dead = subprocess.Popen(["true"])
    dead.wait()
    (checkout / ".venv.lock").symlink_to(str(dead.pid))


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    [
        remove_the_stamp,
        leave_an_empty_folder,
        lose_the_interpreter,
        leave_the_lock_of_a_dead_process,
    ],
)
def test_a_damaged_environment_is_repaired(machine, damage):
    """The next call repairs an interrupted set-up and a missing interpreter."""
    machine.python("python3")
    machine.set_up()
    (machine.checkout / ".venv" / "half").touch()
    damage(machine.checkout)
    assert [line.split()[0] for line in machine.set_up()] == ["pip", "uv", "uv"]
    assert not (machine.checkout / ".venv" / "half").exists()
    assert machine.set_up() == []


@pytest.mark.slow
def test_a_moved_checkout_gets_a_new_environment(machine):
    """The old environment would import the files of the old location."""
    machine.python("python3")
    machine.set_up()
    machine.checkout = machine.checkout.rename(machine.checkout.with_name("elsewhere"))
    assert len(machine.set_up()) == 3
    assert machine.set_up() == []


@pytest.mark.slow
def test_the_environment_may_have_another_name(machine):
    """VENV names it; a folder that is not an environment is not touched."""
    machine.python("python3")
    assert len(machine.set_up("VENV=env", "env/ready")) == 3
    work = machine.checkout / "work"
    work.mkdir()
    (work / "thesis").touch()
    assert "VENV=work exists and is not a virtual env" in machine.refusal("VENV=work", "work/ready")
    assert (work / "thesis").exists()


@pytest.mark.slow
def test_an_additional_lock_file_extends_the_environment(machine):
    """A target with its own packages adds them to the common environment."""
    machine.python("python3")
    machine.set_up()
    packages, _ = machine.set_up(".venv/ready-lab")
    assert packages.endswith("-r requirements.lock -r requirements-lab.lock")
    assert machine.set_up(".venv/ready-lab") == []


@pytest.mark.slow
def test_packages_are_fetched_with_the_certificates_of_the_system_if_those_of_uv_fail(machine):
    """A network that inspects TLS is trusted by the system, and unknown to uv's certificates."""
    untrusted = "import os\nif 'UV_SYSTEM_CERTS' not in os.environ: sys.exit('UnknownIssuer')\n"
    machine.stand_in("uv.py", RECORD.replace("NAME", "uv") + untrusted)
    machine.python("python3")
    assert [line.split()[0] for line in machine.set_up()] == ["pip", "uv", "uv", "uv"]


@pytest.mark.slow
def test_the_first_suitable_python_is_used(machine):
    """A shim without a Python, an old Python and one without ensurepip are skipped."""
    machine.command("python3.14", "echo 'pyenv: python3.14: command not found' >&2; exit 127")
    machine.python("python3.13", BARE)
    machine.python("python3.12", OLD)
    machine.python("python3")
    assert machine.set_up()[0].startswith("pip install")


@pytest.mark.slow
def test_the_python_can_be_chosen(machine):
    """PYTHON may name a Python that is not on the PATH."""
    machine.python("a python")
    assert len(machine.set_up(f"PYTHON={machine.bin / 'a python'}", ".venv/ready")) == 3


@pytest.mark.slow
def test_without_ensurepip_the_pip_of_the_system_is_used(machine):
    """Debian's python3 without python3-venv, but with python3-pip, is such a case."""
    machine.python("python3", BARE)
    bring_uv, *_ = machine.set_up()
    assert re.match(r"pip --python \.venv/bin/python install .*--require-hashes", bring_uv)


@pytest.mark.slow
def test_without_ensurepip_and_pip_the_uv_of_the_system_is_used(machine):
    """It makes the environment and installs the pinned uv, which does the rest."""
    machine.python("python3", PIPLESS)
    record = f'echo "system uv $@" >>"{machine.stand_ins}/record"'
    venv = f'shift $(($# - 1)); "{sys.executable}" -m venv --without-pip "$1"'
    give = f'"{sys.executable}" "{machine.stand_ins}/give.py" "$VIRTUAL_ENV" uv'
    machine.command("uv", f"{record}\ncase $1 in venv) {venv};; pip) {give};; esac")
    requests = machine.set_up()
    assert [line.rsplit(" pip install")[0] for line in requests[2:]] == ["system uv", "uv", "uv"]
    assert requests[1].startswith("system uv venv --quiet --no-python-downloads --python python3")


INSTALLERS = {
    "apt-get": "sudo apt-get install {debian} {debian}-venv",
    "brew": "brew install python@3.13",
    "dnf": "sudo dnf install python3.12",
    None: "make PYTHON=/path/to/python3.11 (see https://www.python.org/downloads)",
}


@pytest.mark.slow
@pytest.mark.parametrize("installer", INSTALLERS)
@pytest.mark.parametrize(
    ("mask", "reason", "debian"),
    [
        (None, "Python 3.11 or newer is needed and none is on the PATH", "python3"),
        (OLD, "Python 3.11 or newer is needed and python3 is 3.9", "python3.11"),
        (
            PIPLESS,
            "python3 cannot make a virtual environment, because it lacks ensurepip",
            "python{}.{}".format(*sys.version_info),
        ),
    ],
)
def test_a_missing_python_is_reported_with_the_command_to_install_it(
    machine, mask, reason, debian, installer
):
    """One sentence states the reason and ends with the command for this machine."""
    if mask is not None:
        machine.python("python3", mask)
    if installer is not None:
        machine.command(installer, "exit 1")
    assert machine.refusal() == f"{reason}; type: {INSTALLERS[installer].format(debian=debian)}"


def test_a_chosen_python_that_does_not_run_is_reported(machine):
    """No other Python is tried, since the choice was explicit."""
    machine.python("python3")
    sentence = machine.refusal("PYTHON=python9", ".venv/ready")
    assert sentence == "PYTHON=python9 does not run; type: make PYTHON=/path/to/python3.11"


# --- the lock files ---------------------------------------------------------------------------


def canonical(requirement: str) -> str:
    name = re.match(r"[A-Za-z0-9._-]+", requirement).group()
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(lock: Path) -> dict[str, list[str]]:
    """The requirements of a lock file by name, each with its continuation lines."""
    entries: dict[str, list[str]] = {}
    for line in lock.read_text().splitlines():
        if re.match(r"[a-z0-9]", line):
            entry = entries.setdefault(canonical(line), [])
        if not line.strip().startswith("#"):
            entry.append(line)
    return entries


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_a_lock_file_names_no_package_index(lock):
    """Any mirror can serve it: it contains no options for pip and no addresses."""
    text = lock.read_text()
    assert "://" not in text
    assert not re.search(r"^\s*-", re.sub(r"^ +--hash=sha256:[0-9a-f]{64}", "", text, flags=re.M))


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_a_lock_file_pins_every_package_by_hash(lock):
    """Each package has one version, for Linux and macOS, and at least one hash."""
    for lines in pins(lock).values():
        assert re.search(r"==[0-9][^ ]* ; .*'(linux|darwin)'", lines[0])
        assert any("--hash=sha256:" in line for line in lines)


def test_the_lock_files_contain_the_dependencies_of_pyproject():
    """Added and removed dependencies have been locked."""
    settings, course = (
        tomllib.loads((ROOT / folder / "pyproject.toml").read_text()) for folder in (".", "src")
    )
    project = settings["project"]
    extras = project["optional-dependencies"] | course["project"]["optional-dependencies"]
    extras |= settings["dependency-groups"]
    asked = {
        "requirements.lock": [
            *("pictures", "mesh", "surface", "parquet", "frames", "crs", "dask", "report", "grade"),
            *("test", "lint"),
        ],
        "requirements-lab.lock": ["lab"],
        "requirements-browser.lock": ["browser"],
        "requirements-docs.lock": ["docs"],
        "requirements-bench.lock": ["bench"],
        "requirements-mutation.lock": ["mutation"],
    }
    extras.pop("all")  # combines the other extras
    extras.pop("setup")  # has its own lock file
    assert sorted(extras) == sorted(name for names in asked.values() for name in names)
    direct = r"# +(via )?fieldrecon(-course)? \((src/)?pyproject\.toml(:\w+)?\)"
    for lock, names in asked.items():
        wanted = {*project["dependencies"], *(r for name in names for r in extras[name])}
        wanted |= set(course["project"]["dependencies"]) if "report" in names else set()
        blocks = re.split(r"^(?=[a-z0-9])", (ROOT / lock).read_text(), flags=re.M)
        locked = {canonical(block) for block in blocks if re.search(direct, block)}
        assert locked == set(map(canonical, wanted)) - {"fieldrecon", "fieldrecon-course"}, lock
    setup = {*settings["dependency-groups"]["setup"], *settings["build-system"]["requires"]}
    assert set(pins(ROOT / "requirements-setup.lock")) == set(map(canonical, setup))
