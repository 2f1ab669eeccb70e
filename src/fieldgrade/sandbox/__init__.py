"""The students' side of the sandbox: it runs their code and restricts its own process.

``server`` forks a process for each submission. The child restricts itself by limits (``confine``),
Landlock rules (``landlock``) and a seccomp filter (``seccomp``), then runs cells and calls
(``worker``), which arrive as ``frames``; ``homes`` empties its folder. ``notebook_code`` translates
magics, ``statements`` splits a cell, ``blocks`` finds what a failure keeps from running, and
``cells`` runs it. ``given_functions`` stand for earlier answers whose values the grader computes.
This package is copied to a folder of its own and runs there without the rest of the project, so
that no solution, no expected value and no tolerance is on this side.
"""
