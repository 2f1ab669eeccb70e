"""Constructed inputs that several questions share."""
