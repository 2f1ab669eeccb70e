"""``python -m fieldreport``: the same as ``fieldrecon report``."""

import argparse
import sys

from fieldreport.commands.report import add_arguments, main

if __name__ == "__main__":
    PARSER = argparse.ArgumentParser(prog="fieldrecon report", description="Build the report.")
    add_arguments(PARSER)
    sys.exit(main(PARSER.parse_args()))
