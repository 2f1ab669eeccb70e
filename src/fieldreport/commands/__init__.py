"""The commands ``fieldrecon experiments`` and ``fieldrecon report``."""

from fieldrecon.cli.commands import Command

EXPERIMENTS = Command("fieldreport.commands.experiments", "list, show and run the experiments")
REPORT = Command("fieldreport.commands.report", "run the experiments and build the report")
