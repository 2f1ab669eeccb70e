"""Conservative transfer between two meshes of one surface, as in aeroelasticity.

Displacements are transferred by the weights H, loads by its transpose, so that the virtual work
is the same on both sides. Wendland (2005), section 1.2.
"""

from fieldrecon.coupling.fixed_point_iteration import FixedPoint, fixed_point
from fieldrecon.coupling.flat_structures import FlatCoupling, couple
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment, rigid_motions
from fieldrecon.coupling.transfer import Coupling, Transfer

__all__ = [
    "Coupling",
    "FixedPoint",
    "FlatCoupling",
    "Transfer",
    "couple",
    "fixed_point",
    "net_force_and_moment",
    "rigid_motions",
]
