"""Build notebooks, known answers and stubs from the sources, if they are out of date."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

import nbformat

from fieldcheck.questions import questions
from fieldgrade.authoring.bundle import student_tree
from fieldgrade.authoring.course_map import DIAGRAM, PAGE, map_diagram, map_page
from fieldgrade.authoring.hidden_cases import hidden_cases
from fieldgrade.authoring.known_answers import answers_file, same_answers
from fieldgrade.authoring.leaks import code_leaks, long_numbers, number_leaks, numbers_of
from fieldgrade.authoring.notebooks import execute, solved_notebook, stub, student_notebook, to_text
from fieldgrade.authoring.orientation import table
from fieldgrade.authoring.outline import Outline, points
from fieldgrade.authoring.sources import Source, sources
from fieldgrade.authoring.trials import trials
from fieldrecon._core.atomic_files import write_if_changed
from fieldrecon._core.digests import bytes_digest, json_digest

Each = Callable[[Callable[[Source], None], list[Source]], Iterable[None]]
NOTHING: Mapping[Path, str] = MappingProxyType({})


def all_sources(root: Path) -> list[Source]:
    """Return the sources of a checkout.

    Raises
    ------
    ValueError
        There are none.
    """
    found = list(sources(root / "solutions"))
    if not found:
        raise ValueError(f"there is no notebook in {root / 'solutions'}; run this in a checkout")
    return found


def require_questions(source: Source) -> None:
    """Raise ValueError if a source has cells for questions without a `Question`."""
    missing = [name for name in source.answer_cells() if name not in questions()]
    if missing:
        raise ValueError(
            f"{source.path.name} has a cell for {', '.join(missing)}, and no module "
            f"src/fieldcheck/questions/q{source.name}.py defines these questions"
        )


def require_outline(source: Source) -> None:
    """Raise ValueError if the outline of a source is incomplete, or its core too long."""
    problems = Outline(source).problems()
    if problems:
        raise ValueError("; ".join(problems))


def build(root: Path, chosen: list[Source], each: Each = map) -> None:
    """Write exercises, known answers, stubs, and executed solutions that are out of date.

    Raises
    ------
    ValueError
        An outline is incomplete, or a part of a solution would reach the students. No file is
        written.
    """
    for source in chosen:
        require_outline(source)
    files = {
        root / "src/fieldcheck/stubs.json": stubs_file(root),
        root / "src/fieldcheck/outline.json": outline_file(root),
        root / PAGE: map_page(all_sources(root)),
        root / DIAGRAM: map_diagram(all_sources(root)),
    }
    for source in chosen:
        files |= student_files(root, source)
    problems = list(dict.fromkeys(leaks(root, "fieldrecon", files)))
    if problems:
        raise ValueError("files for students would contain solutions: " + "; ".join(problems))
    for file, text in files.items():
        write_if_changed(file, text.encode())
    list(each(lambda source: _solve(root, source), chosen))


def student_files(root: Path, source: Source) -> dict[Path, str]:
    """Return the files for students that are built from a source, with their content."""
    known = root / "src/fieldcheck/answers" / f"{source.number}.json"
    return {
        root / "exercises" / f"{source.name}.ipynb": to_text(student_notebook(source)),
        known: _known_text(known, answers_file(source)),
    }


def _known_text(file: Path, fresh: str) -> str:
    """Return the existing text if it differs only by rounding errors."""
    kept = file.read_text(encoding="utf-8") if file.is_file() else "{}"
    return kept if same_answers(kept, fresh) else fresh


def stubs_file(root: Path) -> str:
    """Return the text of ``fieldcheck/stubs.json``: the original cells of students' notebooks."""
    cells = {
        name: stub(cell)
        for source in all_sources(root)
        for name, cell in source.answer_cells().items()
    }
    return json.dumps(cells, indent=0, ensure_ascii=False) + "\n"


def outline_file(root: Path) -> str:
    """Return the text of ``fieldcheck/outline.json``.

    It has the names of the optional questions, and the points of the answers in words of the core
    of each notebook.
    """
    outlines = {source.number: Outline(source) for source in all_sources(root)}
    text = {
        "optional": [item.question for o in outlines.values() for item in o.optional],
        "points_in_words": {
            number: points(item for item in o.core if not item.function)
            for number, o in outlines.items()
        },
    }
    return json.dumps(text, indent=0) + "\n"


def solved_file(root: Path, source: Source) -> Path:
    """Return the path of the executed solution."""
    return root / "solutions" / f"{source.name}.ipynb"


def is_solved(root: Path, source: Source) -> bool:
    """Whether the executed solution is up to date with its source and the checks."""
    file = solved_file(root, source)
    if not file.is_file():
        return False
    executed = nbformat.reads(file.read_text(encoding="utf-8"), as_version=4)
    return bool(executed["metadata"]["course"].get("made_of") == ingredients(root, source))


def ingredients(root: Path, source: Source) -> str:
    """Return a digest of all that an executed solution depends on."""
    package = root / "src/fieldcheck"
    files = [*sorted(package.glob("*.py")), *sorted(package.glob("*.js"))]
    files += [package / "answers" / f"{source.number}.json"]
    files += sorted((package / "questions").glob(f"q{source.number}_*.py"))
    makers = ("notebooks.py", "orientation.py", "outline.py")
    files += [Path(__file__).with_name(maker) for maker in makers]
    digests = (bytes_digest(file.read_bytes()) for file in [source.path, *files])
    return json_digest(*digests, table(Outline(source)))


def solve(root: Path, source: Source) -> str:
    """Return the text of the executed solution."""
    notebook = execute(solved_notebook(source))
    notebook["metadata"]["course"]["made_of"] = ingredients(root, source)
    return to_text(notebook)


def _solve(root: Path, source: Source) -> None:
    if not is_solved(root, source):
        write_if_changed(solved_file(root, source), solve(root, source).encode())


def leaks(root: Path, salt: str, made: Mapping[Path, str] = NOTHING) -> Iterator[str]:
    """Yield parts of solutions and hidden cases in files for students.

    Parameters
    ----------
    root : Path
        The checkout.
    salt : str
        The seed of the hidden inputs.
    made : mapping
        Files that are not written yet, with their content.
    """
    there = (path for _, path in student_tree(root) if path.is_file() and path not in made)
    texts = {path: path.read_text(encoding="utf-8") for path in there} | dict(made)
    files = {path.relative_to(root).as_posix(): text for path, text in texts.items()}
    written = {name: long_numbers(text) for name, text in files.items()}
    for source in all_sources(root):
        yield from code_leaks(source, files)
        functions, hidden = source.functions(), hidden_cases(source)
        for question in questions().values():
            if question.notebook == source.number:
                public, *others = trials(question, functions, (), hidden, "leak", salt)
                known = numbers_of(public.calls, public.answers.right)
                for trial in others:
                    yield from number_leaks(trial.calls, trial.answers.right, written, known)
