"""The build of the report: it repeats outdated steps only, and can be interrupted at any time."""

import errno
import hashlib
import json
import re
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

from fieldrecon._core.atomic_files import temporary_beside
from fieldreport.build import (
    build,
    pinned_kernels,
    reproducibility,
    rerun,
    step_records,
    typesetting,
    up_to_date,
)
from fieldreport.build.chapter_pages import HEADING
from fieldreport.build.lock import only_build_in
from fieldreport.commands import report as command
from fieldreport.framework import result_files as files
from report_fixtures import SmallReport


def skip_typesetting(self, values, metadata):  # noqa: ARG001
    """Stand in for the typesetting, which takes seconds: each file is a chapter without text."""
    labels = [label for path in self.chapters for label in HEADING.findall(path.read_text())]
    sections = "".join(f'<section id="{label}" class="level2">' for label in labels)
    files.write_atomically(self.page, f"<main>{sections}</main>".encode())
    files.write_atomically(self.page.with_name("fonts.css"), b"")
    return [
        files.write_atomically(self.out / f"report.{kind}", json.dumps(values).encode())
        for kind in ("html", "pdf")
    ]


DRAWN_A, DRAWN_B = ["draw fake_a"] * 2, ["draw fake_b"] * 2
"""A figure is drawn for print and, if the print changed, for the screen."""
BUILT = [*DRAWN_A, *DRAWN_B, "run fake_a", "run fake_b"]


@pytest.fixture
def report(tmp_path, monkeypatch):
    monkeypatch.setattr(typesetting.Document, "compile", skip_typesetting)
    return SmallReport(tmp_path, monkeypatch)


@pytest.fixture
def built(report):
    assert report.build() == 0
    assert sorted(report.did()) == BUILT
    return report


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A report with its text, built once."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        report = SmallReport(tmp_path_factory.mktemp("whole"), monkeypatch)
        assert report.build() == 0
        report.did()
        yield report


@pytest.mark.slow
def test_the_manifest_records_inputs_and_outputs(whole):
    """It contains versions, pins, parameters, seeds, and the SHA-256 of every output."""
    reported = json.loads((whole.out / "manifest.json").read_text())
    outputs = whole.outputs()
    del outputs["manifest.json"]
    assert reported["sha256"] == {n: hashlib.sha256(b).hexdigest() for n, b in outputs.items()}
    assert reported["experiments"]["fake_a"]["params"]["points"] == 1000
    assert reported["experiments"]["fake_a"]["seeds"] == {"seed": 7}
    assert reported["pins"] == pinned_kernels.pins()
    assert set(reported["versions"]) >= {"python", "numpy", "scipy", "typst", "pypandoc_binary"}


@pytest.mark.slow
def test_a_second_build_does_nothing(whole):
    """It runs, draws and writes nothing."""
    times = {path: path.stat().st_mtime_ns for path in whole.out.rglob("*.*") if path.is_file()}
    assert whole.build() == 0
    assert whole.did() == []
    assert [path.name for path, time in times.items() if path.stat().st_mtime_ns != time] == []


@pytest.mark.slow
def test_builds_in_two_folders_have_the_same_bytes(whole, tmp_path, monkeypatch):
    """Folder and time zone do not matter; a single changed byte is detected."""
    monkeypatch.setenv("TZ", "Pacific/Kiritimati")
    other = tmp_path / "another folder" / "out"
    assert whole.build(f"--out={other}") == 0
    assert reproducibility.different(whole.out, other) == []
    pdf = other / "report.pdf"
    pdf.write_bytes(pdf.read_bytes().replace(b"%PDF", b"%PDG", 1))
    assert reproducibility.different(whole.out, other) == ["report.pdf"]


class TestOutdatedSteps:
    """A change repeats the steps that depend on it, and no others."""

    @pytest.mark.slow
    def test_a_changed_parameter_runs_and_draws_its_experiment(self, built):
        (built.source / "experiments.toml").write_text("[fake_b]\nepsilon = 0.5\n")
        assert built.build() == 0
        assert built.did() == ["run fake_b", "draw fake_b"]

    @pytest.mark.slow
    def test_a_parameter_set_to_its_default_changes_nothing(self, built):
        (built.source / "experiments.toml").write_text("[fake_a]\npoints = 1000\n")
        assert built.build() == 0
        assert built.did() == []

    @pytest.mark.slow
    def test_a_changed_plot_is_drawn_without_a_run(self, built):
        built.write_experiment("fake_a", 'line("MLS")', 'line("LS")')
        assert built.build() == 0
        assert built.did() == DRAWN_A

    @pytest.mark.slow
    def test_comments_docstrings_and_layout_change_nothing(self, built):
        built.write_experiment("fake_a", "SCALE = 1.0", "\n\n# a comment\nSCALE = (\n    1.0)")
        built.write_experiment("fake_b", "Draw the line.", "Draw the curve.")
        assert built.build() == 0
        assert built.did() == []

    @pytest.mark.slow
    def test_a_changed_constant_used_by_run_repeats_the_run(self, built):
        built.write_experiment("fake_a", "SCALE = 1.0", "SCALE = 2.0")
        assert built.build() == 0
        assert built.did() == ["run fake_a", "draw fake_a"]

    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["fake_a.svg", "facts.json", "errors.csv"])
    def test_a_missing_or_damaged_output_is_restored(self, built, name):
        """The restored file has the same bytes."""
        before = built.outputs()
        path = built.out / "experiments" / "fake_a" / name
        path.write_bytes(b"damaged")
        assert built.build() == 0
        path.unlink()
        assert built.build() == 0
        assert built.outputs() == before

    @pytest.mark.slow
    def test_the_results_of_a_removed_experiment_are_removed(self, built):
        (built.code / "fake_b.py").unlink()
        assert built.build() == 0
        assert not (built.out / "experiments" / "fake_b").exists()

    @pytest.mark.slow
    def test_files_of_others_stay_and_stop_nothing(self, built):
        """Also those beside results and figures, and in the folder of a removed experiment."""
        results = built.out / "experiments"
        names = (
            ".DS_Store",
            "mine/thesis.txt",
            "mine/deep/er.txt",
            "fake_b/mine.svg",
            "fake_b/a.txt",
            "fake_a/mine.csv",
        )
        others = [results / name for name in names] + [built.out / "widgets" / "mine.json"]
        for path in others:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("mine")
        (built.code / "fake_b.py").unlink()
        assert built.build() == 0
        assert [path.read_text() for path in others] == ["mine"] * len(others)
        left = [path.name for path in (results / "fake_b").iterdir()]
        assert sorted(left) == ["a.txt", "mine.svg"]

    @pytest.mark.slow
    def test_the_page_of_a_removed_chapter_is_removed(self, built):
        """Pages of others stay, and no page is removed that only a damaged record could name."""
        pages, chapter = built.out / "pages", built.source / "chapters" / "02-new.md"
        mine = pages / "mine.html"
        mine.write_text("mine")
        before = built.outputs()
        for record in (None, "", "[]", "{}"):
            chapter.write_text("# New {#sec:new}\n")
            assert built.build() == 0
            assert (pages / "new.html").exists()
            if record is not None:
                (built.out / ".state" / "pages.json").write_text(record)
            chapter.unlink()
            assert built.build() == 0
            assert (pages / "new.html").exists() == (record is not None)
            if record is None:
                assert built.outputs() == before
            assert mine.read_text() == "mine"

    @pytest.mark.slow
    @pytest.mark.parametrize("text", ["", "[]", "{}"])
    def test_a_damaged_record_of_a_removed_experiment_stops_nothing(self, built, text):
        """Its files stay, since nothing says that the build made them."""
        (built.out / ".state" / "run-fake_b.json").write_text(text)
        (built.code / "fake_b.py").unlink()
        assert built.build() == 0
        assert (built.out / "experiments" / "fake_b" / "facts.json").exists()

    @pytest.mark.slow
    def test_a_typing_error_is_told_before_anything_runs(self, report, capfd):
        """The message has file and line; facts and tables are known once the experiment has run."""
        report.write_chapter("As in @nobody1900.")
        assert report.build() == 1
        assert report.did() == []
        assert re.search(
            r"chapters/01-all\.md:\d+: references\.bib has no work", capfd.readouterr().err
        )
        report.write_chapter()
        assert report.build() == 0
        report.did()
        table = "::: {.result #tbl:b experiment=fake_a table=errors columns=j}\nErrors.\n:::"
        report.write_chapter("It is {{fake_a.smal:.1e}}.\n\n![A.](fake_c.svg)\n\n" + table)
        report.write_experiment("fake_b", "SCALE = 1.0", "SCALE = 2.0")
        assert report.build() == 1
        assert report.did() == []
        told = capfd.readouterr().err
        assert "fake_a has no fact smal" in told
        assert "no experiment draws the figure fake_c.svg" in told
        assert "no column 'j'; there are error [m], exact, k" in told
        (report.source / "references.bib").unlink()
        assert report.build() == 1
        assert "there is no " in capfd.readouterr().err

    @pytest.mark.slow
    def test_option_only_builds_one_experiment(self, report):
        """Other experiments and the text are not built."""
        assert report.build("--only", "fake_b") == 0
        assert report.did() == ["run fake_b", "draw fake_b"]
        assert not (report.out / "report.html").exists()


CHANGES = {
    "a chapter": lambda r: r.write_chapter("More."),
    "a new chapter": lambda r: (r.source / "chapters" / "02-new.md").write_text("# New\n"),
    "a style": lambda r: (r.source / "style.css").write_text(""),
    "a pass": lambda r: (r.source / "filters" / "new.lua").write_text(""),
    "a parameter": lambda r: (r.source / "experiments.toml").write_text("[fake_a]\nseed = 3\n"),
    "a comment in the code": lambda r: r.write_experiment("fake_a", "SCALE", "# S\nSCALE"),
    "a new module": lambda r: (r.code / "new.py").write_text(""),
    "a removed experiment": lambda r: (r.code / "fake_b.py").unlink(),
    "a removed output": lambda r: (r.out / "report.pdf").unlink(),
    "a changed output": lambda r: (r.out / "report.html").write_text("changed"),
    "a changed table": lambda r: next(r.out.rglob("errors.csv")).write_text("changed"),
    "a file too many": lambda r: (r.out / "experiments" / "fake_a" / "old.svg").write_text(""),
    "a lost note": lambda r: (r.out / ".state" / "build.json").unlink(),
    "a changed input": lambda r: (r.source / "data.json").write_text("changed"),
    "a removed input": lambda r: (r.source / "data.json").unlink(),
}


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """A report in which an experiment reads a file, built once."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(typesetting.Document, "compile", skip_typesetting)
        report = SmallReport(tmp_path_factory.mktemp("unchanged"), monkeypatch)
        (report.source / "data.json").write_text("measured")
        read = f'field(default="{report.source / "data.json"}", metadata={{"file": True}})'
        report.write_experiment(
            "fake_a",
            *("    seed: int", f"    data: str = {read}\n    seed: int"),
            *("import dataclass", "import dataclass, field"),
        )
        assert report.build() == 0
        yield report


def is_up_to_date(report):
    return up_to_date.is_up_to_date(report.options())


class TestUpToDate:
    """Files alone decide whether the report is up to date; any relevant change is detected."""

    @pytest.fixture
    def report(self, once):
        """The report, which is restored after the test."""
        before = {p: p.read_bytes() for p in once.folder.rglob("*") if p.is_file()}
        assert is_up_to_date(once)
        yield once
        for path in once.folder.rglob("*"):
            if path.is_file() and path not in before:
                path.unlink()
        for path, content in before.items():
            path.write_bytes(content)
        assert is_up_to_date(once)

    @pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
    def test_a_change_is_detected(self, report, change):
        """The changes are in code, text, parameters, inputs and outputs."""
        change(report)
        assert not is_up_to_date(report)

    def test_another_package_version_is_detected(self, report, tmp_path, monkeypatch):
        (tmp_path / "site" / "numpy-99.0.dist-info").mkdir(parents=True)
        monkeypatch.syspath_prepend(tmp_path / "site")
        assert not is_up_to_date(report)

    def test_another_python_is_detected(self, report, monkeypatch):
        """Version and build of Python are compared."""
        other = SimpleNamespace(version="4.0", path=sys.path, stderr=sys.stderr)
        monkeypatch.setattr(up_to_date, "sys", other)
        assert not is_up_to_date(report)

    @pytest.mark.slow
    def test_a_build_starts_only_after_a_change(self, report, monkeypatch):
        """The following build has nothing to do."""
        begun = []

        def begin(arguments, whole=build.build):
            begun.append(arguments)
            whole(arguments)

        monkeypatch.setattr(build, "build", begin)
        monkeypatch.setattr(typesetting.Document, "compile", skip_typesetting)
        assert report.build() == 0
        assert begun == []
        (report.source / "data.json").write_text("measured again")
        report.did()
        assert report.build() == 0
        assert report.did() == ["run fake_a"]
        assert report.build() == 0
        assert len(begun) == 1

    def test_the_check_imports_no_numerical_packages(self):
        """The check also avoids matplotlib."""
        code = (
            "import sys, fieldreport.commands.report; "
            "print([n for n in ('numpy', 'matplotlib', 'fontTools', 'rich') if n in sys.modules])"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        assert done.stdout == "[]\n"

    def test_the_check_creates_no_folder(self, report):
        """A call with a wrong source folder leaves nothing there."""
        assert report.build("--source", str(report.source / "nowhere")) == 1
        assert not (report.source / "nowhere").exists()


class Killed(BaseException):
    """Represents the end of the process, which no code may catch."""


@pytest.mark.slow
@pytest.mark.parametrize("moment", [0, 5, 14, 16])
def test_a_build_killed_during_a_write_is_completed_by_the_next(report, monkeypatch, moment):
    """Whichever write was interrupted, the next build gives the files of an undisturbed build."""
    written = []

    def write(path, content, whole=files.write_atomically):
        if len(written) == moment:
            path.parent.mkdir(parents=True, exist_ok=True)
            left = temporary_beside(path)
            left.write_bytes(content[: len(content) // 2])
            raise Killed
        written.append(path)
        return whole(path, content)

    with monkeypatch.context() as during:
        for module in (files, rerun, build, step_records):
            during.setattr(module, "write_atomically", write)
        with pytest.raises(Killed):
            report.build()
    assert report.build() == 0
    clean = report.source / "clean"
    assert report.build(f"--out={clean}") == 0
    assert report.outputs() == report.outputs(clean)


@pytest.mark.slow
def test_a_second_build_waits_and_reports_it(tmp_path):
    """It continues when the first build ends."""
    messages, entered = [], threading.Event()

    def second():
        with only_build_in(tmp_path, messages.append):
            entered.set()

    with only_build_in(tmp_path, messages.append):
        waiting = threading.Thread(target=second)
        waiting.start()
        assert not entered.wait(0.3)
    waiting.join(5)
    assert entered.is_set()
    assert messages == [f"another build is at work in {tmp_path}; waiting for it to end"]


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "the disk is full"),
        (errno.EROFS, "the file system is read-only"),
        (errno.EACCES, "permission is denied"),
    ],
)
def test_a_write_error_is_reported_in_one_line(report, monkeypatch, capfd, number, words):
    """The exit status is 1, and there is no traceback."""

    def write(path, content):  # noqa: ARG001
        raise OSError(number, "told by the system", str(path))

    monkeypatch.setattr(files, "write_atomically", write)
    assert report.build() == 1
    reported = capfd.readouterr().err
    assert re.search(rf"cannot write .*fake_a/params.json: {words}$", reported.strip())
    assert "Traceback" not in reported


def test_a_file_in_place_of_the_build_folder_is_reported(report, capfd):
    (report.source / "taken").write_text("")
    assert report.build(f"--out={report.source / 'taken'}") == 1
    assert "a file stands where a folder is wanted" in capfd.readouterr().err


def test_an_interrupted_build_is_reported_without_a_traceback(report, monkeypatch, capfd):
    """Ctrl-C gives an exit status of its own."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(rerun, "write_result", interrupted)
    assert report.build() == command.INTERRUPTED
    reported = capfd.readouterr().err
    assert "interrupted" in reported
    assert "Traceback" not in reported


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("[fake_c]\n", r"no experiment 'fake_c'; did you mean fake_[ab]\?"),
        ("[bumps]\n", "no experiment 'bumps'; there are fake_a, fake_b"),
        ("[fake_a]\npoint = 3\n", r"\[fake_a\]: there is no parameter 'point'"),
        ("[fake_a]\npoints = 0.5\n", r"\[fake_a\]: parameter points must be a whole number"),
        ("[fake_a\n", "experiments.toml"),
    ],
)
def test_invalid_settings_stop_the_build(report, capfd, settings, words):
    """A wrong name or value in experiments.toml is reported before anything runs."""
    (report.source / "experiments.toml").write_text(settings)
    assert report.build() == 1
    assert re.search(words, capfd.readouterr().err)
    assert report.did() == []


@pytest.mark.slow
def test_a_failed_experiment_is_reported(report, capfd):
    """The message contains the name of the experiment and the location of the error."""
    report.write_experiment("fake_b", "x = np.linspace", "x = np.no_such_function")
    assert report.build() == 1
    assert re.search(r"experiment fake_b failed(.|\n)*no_such_function", capfd.readouterr().err)


def test_an_experiment_that_fails_with_other_parameters_is_reported(report, capfd):
    """The message names the experiment and the changed parameter, without a traceback."""
    report.write_experiment("fake_b", "x = np.linspace", "x = 10.0 ** params.points, np.linspace")
    (report.source / "experiments.toml").write_text("[fake_b]\npoints = 1001\n")
    assert report.build() == 1
    reported = capfd.readouterr().err
    assert "experiment fake_b fails with points = 1001: " in reported
    assert "Traceback" not in reported


def test_facts_are_compared_to_their_stated_digits():
    """Another machine may differ by one unit of the last digit, and in nothing else."""
    facts = {"x": 1.0, "rough": 1.0, "order": 0.01, "k": 3, "e": 1e-15}

    def digits_of(experiment):
        assert experiment == "a"
        return lambda fact: {"rough": 2, "order": 0}.get(fact, 6)

    def manifest(**changed):
        return {"experiments": {"a": {"params": {"n": 1}, "facts": facts | changed}}}

    def deviations(**changed):
        return list(reproducibility.deviations(manifest(), manifest(**changed), digits_of))

    for near in ({"x": 1.00001}, {"rough": 1.1}, {"order": 0.1}, {"e": 1e-16}, {"e": 1.2e-15}):
        assert deviations(**near) == []
    for far in (
        *({"x": 1.0001}, {"rough": 1.3}, {"order": 1.0}, {"k": 4}, {"e": 1e-12}, {"new": 1.0}),
        *({"x": 10.0}, {"x": 0.0}),
    ):
        assert len(deviations(**far)) == 1, far
    other = {"experiments": {"a": {"params": {"n": 2}, "facts": {}}}}
    reported = list(reproducibility.deviations(manifest(), other, digits_of))
    assert ["parameters" in text for text in reported] == [True]


@pytest.mark.slow
def test_other_pins_repeat_all_steps(built, monkeypatch):
    """Results computed with other pinned kernels are outdated."""
    for module in (rerun, up_to_date):
        monkeypatch.setattr(module, "pins", lambda: {"OPENBLAS_CORETYPE": "another"})
    assert built.build() == 0
    assert sorted(built.did()) == ["draw fake_a", "draw fake_b", "run fake_a", "run fake_b"]
