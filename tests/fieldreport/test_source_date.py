"""The date on the first page is the date of the last commit."""

import os
import subprocess

import pytest

from fieldreport.build.reproducibility import date_of
from fieldreport.build.source_date import source_date


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A repository with one commit, at 23:30 on 1 May 2001 in UTC-5."""
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    when = {"GIT_AUTHOR_DATE": "2001-05-01T23:30:00-0500"}
    when["GIT_COMMITTER_DATE"] = when["GIT_AUTHOR_DATE"]
    who = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
    for command in (["init", "-q"], [*who, "commit", "-q", "--allow-empty", "-m", "first"]):
        subprocess.run(["git", *command], cwd=tmp_path, check=True, env={**os.environ, **when})
    return tmp_path


@pytest.mark.parametrize("zone", ["UTC", "Pacific/Kiritimati"])
def test_the_date_is_that_of_the_last_commit(checkout, monkeypatch, zone):
    """The reader's time zone has no influence."""
    monkeypatch.setenv("TZ", zone)
    assert source_date(checkout) == "2001-05-01"


def test_the_environment_takes_precedence(checkout, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert source_date(checkout) == "1970-01-02"


def test_there_is_no_date_outside_a_repository(tmp_path, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert source_date(tmp_path) == ""


def test_a_copy_outside_the_repository_gets_the_date_of_its_original(checkout, monkeypatch):
    """The build to compare with is made from a copy."""
    (variable,) = date_of(checkout).items()
    monkeypatch.setenv(*variable)
    assert source_date(checkout.parent / "a copy") == "2001-05-01"
