"""Every method obeys every law, and every law catches a mistake."""

import pytest

import laws
from cases import CASES, Case


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("law", laws.LAWS, ids=lambda law: law.__name__)
def test_every_method_obeys_the_law(law, case: Case):
    """The law holds for the method as it is declared."""
    law(case)
