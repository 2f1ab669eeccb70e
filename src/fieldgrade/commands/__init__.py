"""The commands ``fieldrecon course`` and ``fieldrecon grade``."""

from fieldgrade.grading import FOR_WORKERS
from fieldrecon.cli.commands import Command

COURSE = Command(
    "fieldgrade.commands.course", "notebooks, the tests of their graders, the students' bundle"
)
GRADE = Command(
    "fieldgrade.commands.grade", "grade the submissions of a class", for_workers=FOR_WORKERS
)
