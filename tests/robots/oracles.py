"""Other people's models of the same robots: where their packages lie, or a skipped test."""

import importlib.util
from pathlib import Path

import pytest


def package_file(package: str, path: str) -> Path:
    """A file that an installed package ships, without importing it; the test is skipped where it is absent."""
    found = importlib.util.find_spec(package)
    places = list(found.submodule_search_locations or []) if found else []
    files = [Path(place) / path for place in places if (Path(place) / path).is_file()]
    if not files:
        pytest.skip(f"needs {path} of the package {package}, which is not installed")
    return files[0]


def module(name: str):
    """An installed module; the test is skipped where it is absent."""
    try:
        return importlib.import_module(name)
    except ImportError:
        pytest.skip(f"needs the module {name}, which is not installed")
