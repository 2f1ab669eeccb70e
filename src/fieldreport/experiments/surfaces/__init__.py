"""Surfaces from points: implicit functions, variational implicits, polygon soups."""
