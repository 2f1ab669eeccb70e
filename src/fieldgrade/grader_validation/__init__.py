"""Tests of the graders: ``fieldrecon course check``.

``known_verdicts`` grades solution, stub, catalogued mistakes, alternative answers and ``mutants``
of the solution. ``rounding_errors`` and ``blas_kernels`` verify that no verdict depends on
rounding.
"""
