"""The commands ``fieldrecon course`` and ``fieldrecon grade``."""

from fieldrecon.cli.commands import Command

NEEDS = ("fontTools", "jsonschema", "jupytext", "nbclient", "nbconvert", "nbformat", "pytest")

COURSE = Command(
    "fieldgrade.commands.course",
    "notebooks, the tests of their graders, the students' bundle",
    needs=NEEDS,
)
GRADE = Command(
    "fieldgrade.commands.grade",
    "grade the submissions of a class",
    needs=NEEDS,
)
