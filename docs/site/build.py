"""Build the site of the documentation: the command of `make docs` and `make site`.

    python docs/site/build.py OUT [--report PAGES]

PAGES is a folder of chapters as `fieldrecon report` writes it. Warnings are errors.
"""

import argparse
import shutil
import sys
from pathlib import Path
from zipfile import ZipFile, ZipInfo

from sphinx.cmd.build import main as sphinx

import checks
import sources

HERE = Path(__file__).resolve().parent


def main() -> int:
    """Assemble the pages, run Sphinx, and check what it wrote."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--report", type=Path)
    arguments = parser.parse_args()
    out = arguments.out.resolve()
    work = out.with_name(f"{out.name}-work")
    sources.assemble(work / "source", arguments.report)
    remove(out, work / "made.txt")
    others = files(out)
    if arguments.report:
        not_shown = shutil.ignore_patterns("*.html", "*.json")
        shutil.copytree(arguments.report, out / "report", ignore=not_shown, dirs_exist_ok=True)
    folders = [str(folder) for folder in (HERE, work / "doctrees", work / "source", out)]
    status = sphinx(["--fail-on-warning", "-q", "-c", folders[0], "-d", *folders[1:]])
    if status:
        return status
    for archive in out.glob("_downloads/*/*.zip"):
        without_times(archive)
    (out / ".buildinfo").unlink(missing_ok=True)
    (work / "made.txt").write_text("\n".join(sorted(files(out) - others)), encoding="utf-8")
    wrong = checks.problems(out)
    print(*wrong, sep="\n", file=sys.stderr, end="\n" if wrong else "")
    print(f"{out / 'index.html'}")
    return 1 if wrong else 0


def files(out: Path) -> set[str]:
    """Return the names of all files of the site."""
    return {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}


def remove(out: Path, made: Path) -> None:
    """Remove the files of the build before and no others, so that no stale page stays."""
    if made.exists():
        for name in made.read_text(encoding="utf-8").splitlines():
            (out / name).unlink(missing_ok=True)


def without_times(archive: Path) -> None:
    """Write an archive anew with the same time for each file, so that two builds are the same."""
    with ZipFile(archive) as old:
        contents = {name: old.read(name) for name in sorted(old.namelist())}
    with ZipFile(archive, "w") as new:
        for name, content in contents.items():
            new.writestr(ZipInfo(name), content)


if __name__ == "__main__":
    sys.exit(main())
