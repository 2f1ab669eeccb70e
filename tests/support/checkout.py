"""The root of the checkout that contains these tests."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
