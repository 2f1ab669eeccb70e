"""The hostile cases with given functions have teeth, and time carries nothing into the results."""

import pytest

from fieldgrade.checking import grade_submission
from fieldgrade.checking.grade_submission import grade
from hostile import given


@pytest.mark.slow
@pytest.mark.parametrize("case", given.REVEALING[:3], ids=lambda case: case.name)
def test_the_sentences_of_the_second_run_would_reveal_right_values(
    case, course, servers, places, monkeypatch
):
    """If they were kept, as this change does, the secret word would be in the record."""
    monkeypatch.setattr(grade_submission, "with_given", lambda _, again, __: dict(again))
    record = grade(course, servers("none"), case.submission(places.values), ("01.1", "01.2"))
    assert places.secret in repr(record)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["1 / 0", "return np.zeros(9)"])
def test_the_time_and_the_kind_of_a_failure_carry_nothing(how, course, servers):
    """The answer earns as much as one that ignores what it is given."""
    wait = f"if {given.IS_GIVEN}:\n        import time; time.sleep(0.3)\n        {how}"
    grades = [
        grade(
            course,
            servers("none"),
            given.given("", f"{given.DEFINE}    {do}\n    return np.zeros(9)\n").submission({}),
            ("01.1", "01.2"),
        ).grades
        for do in ("basis_matrix(points)", wait)
    ]
    assert [g.verdict.finding for g in grades[0]] == ["wrong", "shape"]
    if how != "1 / 0":
        assert grades[0] == grades[1]
    else:
        assert "ZeroDivisionError" not in repr(grades[1])
