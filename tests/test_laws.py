"""Every method obeys every law, every law rejects its mutants, and every method has a case."""

import importlib
import multiprocessing
import pkgutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from inspect import isabstract

import pytest

import fieldrecon
import laws
from cases import ARRANGEMENTS, CASES, GLOBE_CASES, Case, CornersCase, case
from fieldrecon.kernels.base import Radial, Scaled
from fieldrecon.methods.tangent_plane import OnTangentPlane
from fieldrecon.reconstruction import Reconstruction
from mutants import MUTANTS

PAIRS = [
    pytest.param(law, mutant, id=f"{law.__name__}-{mutant.name}")
    for law, mutants in MUTANTS.items()
    for mutant in mutants
]


# On a line and in space, one weight or kernel of each method; in the plane, all of them.
IN_EVERY_DIMENSION = (
    "LS",
    "MLS ε = 0.1",
    "MLS wendland on",
    "RBF r³",
    "PU r³",
    "Hermite r³",
    "coordinates",
    "Voronoi cell",
)
MORE_WEIGHTS = ("MLS ε = 1", "MLS inverse multiquadric", "MLS gaussian,", "MLS wendland within")
MORE_PATCHES = tuple(f"PU {name}" for name in ("r⁵", "r⁴ log r", "inverse", "gaussian", "Wendland"))


# Larger ones of several of their kind.
LONG = (
    "PU r³ on 10 sites",
    "PU r³ on 16 sites, degree 1, with scales in 3-D",
    "PU r³ on 25 sites, degree 1 in 3-D",
    "PU r³ smoothed",
    "PU thin plate",
    "PU, clusters",
    "PU, hole",
    "PU, tracks",
    "Hermite r³ in 3-D",
    "Hermite r⁴ log r in 2-D",
    "MLS ε = 0, degree 2",
    "MLS ε = 0, degree 3",
    "MLS ε = 0 on 14 nearest",
    "MLS ε = 1, degree 1 in 2-D",
    "MLS gaussian on 14 nearest",
    "MLS ε = 0.1, degree 3",
    "MLS wendland on 8 nearest, degree 1, with a metric",
    "MLS wendland on 11 nearest",
    "MLS wendland on 14 nearest",
    "RBF Wendland 2 on near pairs, a plane",
    "Voronoi cell, a octahedron",
    "Voronoi cell, a parallelepiped",
    "Voronoi cell, a pyritohedron",
    "Voronoi cell, a regular 20-gon",
    "Voronoi cell, a rhombic dodecahedron",
    "coordinates of the pyritohedron",
    "coordinates of the regular 20-gon",
    "coordinates of the rhombic dodecahedron",
    "mean of PU",
)


def is_long(case: Case) -> bool:
    """Whether the case has many variables, or repeats those of another weight or kernel."""
    if case.name.startswith(MORE_WEIGHTS):
        return "degree 1 in 2-D" not in case.name
    if case.name.startswith("RBF") and "one degree more" in case.name:
        return "r³" not in case.name
    with_others = case.d != 2 and not case.name.startswith(IN_EVERY_DIMENSION)
    large = case.d == 3 and case.name.startswith(("MLS", "PU")) and "degree 1" not in case.name
    cubics = case.name.startswith("PU") and "degree 3" in case.name
    return case.d > 3 or with_others or large or cubics or case.name.startswith(MORE_PATCHES + LONG)


METHODS = [
    pytest.param(case, id=case.name, marks=pytest.mark.slow if is_long(case) else ())
    for case in CASES
]


IN_SPACE = [case for case in CASES if not isinstance(case, CornersCase)]


@pytest.mark.parametrize("case", METHODS)
def test_every_method_obeys_the_laws(case: Case):
    laws.assert_obeyed(laws.laws_about(case), case, case.name)


@pytest.mark.parametrize("case", GLOBE_CASES, ids=lambda case: case.name)
def test_methods_on_the_globe_on_arrangements(case: Case):
    """The laws about fields and derivatives on the globe are in test_globe."""
    laws.arrangements_are_solved_or_refused(case)


@pytest.mark.slow
@pytest.mark.parametrize("case", [*IN_SPACE, *GLOBE_CASES], ids=lambda case: case.name)
def test_every_method_on_every_arrangement(case: Case):
    """On the arrangements that the law does not draw as well."""
    names = tuple(name for name, a in ARRANGEMENTS.items() if case.d >= a.d)
    laws.arrangements_are_solved_or_refused(replace(case, arrangements=names))


@pytest.mark.parametrize(("law", "mutant"), PAIRS)
def test_the_law_rejects_the_mutant(law, mutant: Case):
    """A wrong method violates the law that it was written for."""
    with pytest.raises(AssertionError):
        law(mutant)


def test_every_law_has_a_mutant():
    """A law without a mutant might be a check that cannot fail."""
    assert set(MUTANTS) == set(laws.LAWS)
    assert all(MUTANTS.values())


def test_every_law_is_applied():
    """Every function of a case is in the list of laws, and applies to at least one case."""
    functions = [f for f in vars(laws).values() if is_law(f)]
    assert functions == laws.LAWS
    assert {law for case in CASES for law in laws.laws_about(case)} == set(laws.LAWS)


def test_every_method_computes_second_derivatives():
    """No case evades the laws about them."""
    without = {type(c.method).__name__ for c in CASES if not laws.has_second_derivatives(c)}
    assert not without, f"define _hessian_rows in {', '.join(sorted(without))}"


def is_law(function) -> bool:
    kinds = getattr(function, "__annotations__", {})
    return kinds.get("case") is Case and kinds["return"] is None


def test_broken_laws_are_named():
    """All laws that the case breaks are reported with their errors."""
    mutants = {mutant.name: mutant for each in MUTANTS.values() for mutant in each}
    wrong = mutants["GradientInLocalCoordinates"]
    with pytest.raises(
        ExceptionGroup, match="GradientInLocalCoordinates breaks 3 of the laws"
    ) as broken:
        laws.assert_obeyed(laws.LAWS[:15], wrong, wrong.name)
    errors = broken.value.exceptions
    assert all("deviates by" in str(error) for error in errors)
    assert [error.__notes__ for error in errors] == [
        ["The law is gradients_of_polynomials_are_reproduced."],
        ["The law is the_gradient_is_the_derivative."],
        ["The law is hessians_are_derivatives_of_gradients."],
    ]


def concrete(base: type) -> set[type]:
    """Concrete subclasses in the library, at any depth."""
    for module in pkgutil.walk_packages(fieldrecon.__path__, "fieldrecon."):
        importlib.import_module(module.name)
    found, new = set(), {base}
    while new:
        new = {s for b in new for s in b.__subclasses__()} - found
        found |= new
    return {c for c in found if c.__module__.startswith("fieldrecon.") and not isabstract(c)}


def test_every_method_has_a_case():
    """Those on the globe and in its tangent plane have their own laws in test_globe."""
    tested = concrete(Reconstruction) - {OnTangentPlane}
    bases = {
        c for case in [*CASES, *GLOBE_CASES] for c in type(case.method).__mro__ if not isabstract(c)
    }
    missing = sorted(c.__name__ for c in tested - bases)
    assert not missing, f"add a case of {', '.join(missing)} to tests/cases.py"


def test_every_radial_function_has_a_case():
    """It is used as a kernel or as a weight."""
    methods = [case.method for case in CASES]
    used = {type(getattr(m, "kernel", getattr(m, "weight", None))) for m in methods}
    assert used - {type(None)} == concrete(Radial) - {Scaled}


def test_names_of_cases_are_unique():
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.slow
def test_processes_and_threads_give_the_same_bits():
    """Methods and fields are pickled for other processes."""
    names = (
        "LS degree 2 in 3-D",
        "MLS ε = 0.1, degree 2 in 2-D",
        "MLS wendland on 8 nearest, degree 1 in 2-D",
        "RBF thin plate in 2-D",
        "PU r³ on 16 sites, degree 3 in 2-D",
    )
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as processes:
        for name in names:
            laws.results_do_not_depend_on_the_executor(case(name), processes)
            laws.making_does_not_depend_on_the_executor(case(name), processes)
