"""The build of the report: what must be rerun, in pinned workers, and typeset as HTML and PDF.

`rerun` runs the experiments whose parameters or code changed; `code_dependencies` says on which
code a result depends, and `step_records` what is up to date. Each file is replaced only when it is
complete, so that a build can be interrupted at any moment.
"""
