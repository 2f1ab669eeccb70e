"""Every method satisfies every law, every law detects its mutants, and no method is missing."""

import importlib
import multiprocessing
import pkgutil
from concurrent.futures import ProcessPoolExecutor
from inspect import isabstract

import pytest

import fieldrecon
import laws
from cases import CASES, Case, case
from fieldrecon.kernels.base import Radial, Scaled
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.reconstruction import Reconstruction
from mutants import MUTANTS

PAIRS = [
    pytest.param(law, mutant, id=f"{law.__name__}-{mutant.name}")
    for law, mutants in MUTANTS.items()
    for mutant in mutants
]


MORE_WEIGHTS = ("MLS ε = 1e-8", "MLS ε = 1,", "MLS inverse multiquadric")


def is_long(case: Case) -> bool:
    """More variables than three, or another weight where a like one has all degrees."""
    return case.d > 3 or (case.name.startswith(MORE_WEIGHTS) and "degree 1 in 2-D" not in case.name)


METHODS = [
    pytest.param(case, id=case.name, marks=pytest.mark.slow if is_long(case) else ())
    for case in CASES
]


@pytest.mark.parametrize("case", METHODS)
def test_every_method_obeys_the_laws(case: Case):
    """All that are about the case hold for the method as it is declared."""
    laws.assert_obeyed(laws.laws_about(case), case, case.name)


@pytest.mark.parametrize(("law", "mutant"), PAIRS)
def test_the_law_catches_the_mutant(law, mutant: Case):
    """A wrong method breaks the law that is about its mistake."""
    with pytest.raises(AssertionError):
        law(mutant)


def test_every_law_has_been_seen_to_fail():
    """A law without a mutant may be a check that cannot fail."""
    assert set(MUTANTS) == set(laws.LAWS)
    assert all(MUTANTS.values())


def test_every_law_is_applied():
    """A function that returns nothing about a case is in the list, and is about some of them."""
    functions = [f for f in vars(laws).values() if is_law(f)]
    assert functions == laws.LAWS
    assert {law for case in CASES for law in laws.laws_about(case)} == set(laws.LAWS)


def is_law(function) -> bool:
    kinds = getattr(function, "__annotations__", {})
    return kinds.get("case") is Case and kinds["return"] is None


def test_a_broken_law_is_named():
    """With every other law that the case breaks, and what was seen."""
    mutants = {mutant.name: mutant for each in MUTANTS.values() for mutant in each}
    wrong = mutants["GradientInTheFrame"]
    with pytest.raises(ExceptionGroup, match="GradientInTheFrame breaks 2 of the laws") as broken:
        laws.assert_obeyed(laws.LAWS[:15], wrong, wrong.name)
    errors = broken.value.exceptions
    assert all("deviates by" in str(error) for error in errors)
    assert [error.__notes__ for error in errors] == [
        ["The law is gradients_of_polynomials_are_reproduced."],
        ["The law is the_gradient_is_the_derivative."],
    ]


def concrete(base: type) -> set[type]:
    """Subclasses of the library, at any depth, that are not abstract."""
    for module in pkgutil.walk_packages(fieldrecon.__path__, "fieldrecon."):
        importlib.import_module(module.name)
    found, new = set(), {base}
    while new:
        new = {s for b in new for s in b.__subclasses__()} - found
        found |= new
    return {c for c in found if c.__module__.startswith("fieldrecon.") and not isabstract(c)}


def test_every_method_is_among_the_cases():
    """A new method is judged, or this fails; the globe has laws of its own, in test_globe."""
    judged = concrete(Reconstruction) - {OnGlobe}
    bases = {c for case in CASES for c in type(case.method).__mro__ if not isabstract(c)}
    missing = sorted(c.__name__ for c in judged - bases)
    assert not missing, f"add a case of {', '.join(missing)} to tests/cases.py"


def test_every_radial_function_is_among_the_cases():
    """As a kernel or as a weight."""
    methods = [case.method for case in CASES]
    used = {type(getattr(m, "kernel", getattr(m, "weight", None))) for m in methods}
    assert used - {type(None)} == concrete(Radial) - {Scaled}


def test_cases_have_names_of_their_own():
    """So that a failure says which it was."""
    assert len({case.name for case in CASES}) == len(CASES)


def test_processes_give_the_bits_of_threads():
    """A method and its field travel to other processes, and their answers back."""
    names = (
        "LS degree 2 in 3-D",
        "MLS ε = 0.1, degree 2 in 2-D",
        "MLS wendland on 8 nearest, degree 1 in 2-D",
        "RBF thin plate in 2-D",
        "PU r³ on 16 sites, degree 3 in 2-D",
    )
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as processes:
        for name in names:
            laws.executors_do_not_matter(case(name), processes)
