"""Semi-Lagrangian advection: the slotted disc, rotation and deformation, an adaptive front."""
