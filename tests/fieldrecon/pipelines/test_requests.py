"""The commands as functions: a request gives the result of the command and reports its stages."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.pipelines import (
    AuditRequest,
    ScanRequest,
    SurveyRequest,
    audit_file,
    reconstruct_scan,
    reconstruct_survey,
)
from fieldrecon.solids.shapes import Ball, sample_surface


def named(seen):
    """A factory of stages that appends the name of each stage to the list."""

    def stages(name):
        seen.append(name)
        return lambda *_: None

    return stages


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give either a table of samples or --load with a field"),
        ({"samples": "a", "load": "b"}, "give either a table of samples or --load with a field"),
        ({"samples": "a", "method": "kriging"}, "there is no method 'kriging'; there are best, "),
    ],
)
def test_invalid_requests_are_refused(arguments, words):
    """No file is read before the check."""
    with pytest.raises(ValueError, match=words):
        SurveyRequest(**arguments)


def test_a_survey_is_evaluated_at_the_points_of_a_table(tmp_path):
    """The result has the stages in order, the chosen method and the values at the targets."""
    points = fr.datasets.uniform(60, 2, seed=0)
    table, seen = tmp_path / "plane.csv", []
    rows = np.column_stack([points, points @ [1.0, 2.0]])
    np.savetxt(table, rows, delimiter=",", header="x,y,value", comments="")
    survey = reconstruct_survey(SurveyRequest(table, method="ls1", at=table), stages=named(seen))
    assert seen[0] == "reading"
    assert seen[-1] == "looking for gaps"
    assert survey.method == "ls1, least squares, plane"
    np.testing.assert_allclose(survey.result.values, points @ [1.0, 2.0])
    assert "0 of 60 points lie outside the convex hull of the samples." in survey.warnings


def test_a_scan_becomes_a_closed_mesh_and_a_damaged_mesh_is_repaired(tmp_path):
    """The mesh of a ball is closed; after removal of one triangle the audit repairs it."""
    cloud = tmp_path / "ball.xyz"
    np.savetxt(cloud, sample_surface(Ball(1.0), 300, seed=1)[0])
    scan = reconstruct_scan(ScanRequest(cloud))
    assert scan.sound(open_allowed=False)
    assert not scan.own_normals
    mesh = tmp_path / "open.stl"
    fr.io.write_triangles(mesh, scan.points, scan.mesh.triangles[1:])
    found = audit_file(AuditRequest(mesh))
    assert found.repair is None
    assert not found.sound(open_allowed=False)
    assert found.sound(open_allowed=True)
    mended = audit_file(AuditRequest(mesh, repair=True))
    assert mended.audit.found == found.audit.found
    assert mended.sound(open_allowed=False)
