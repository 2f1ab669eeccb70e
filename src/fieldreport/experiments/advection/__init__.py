"""Semi-Lagrangian advection: the slotted disc, flows that turn and deform, an adaptive front."""
