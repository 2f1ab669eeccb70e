"""The command line of ``fieldrecon``."""
