"""Modules that all worker processes share: they are imported once, before workers are forked.

The garbage collector writes into each object that it examines, and the system then copies the
memory for each process. Frozen objects are not examined.
"""

import gc

import jupytext  # noqa: F401
import numpy.polynomial
import numpy.testing  # noqa: F401
import scipy.linalg  # noqa: F401

import fieldgrade.authoring.build
import fieldgrade.authoring.right_functions
import fieldgrade.grading.batch  # noqa: F401

gc.collect()
gc.freeze()
