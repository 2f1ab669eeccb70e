"""The build of the report: what must rerun, in pinned workers, and typesetting as HTML and PDF.

`rerun` runs the experiments whose parameters or code changed; `code_dependencies` determines the
code on which a result depends, and `step_records` stores what is up to date. Each file is replaced
only when it is complete, so that a build can be interrupted at any moment.
"""
