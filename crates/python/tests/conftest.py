"""What several tests use."""

import os
import pathlib

import doublet as db
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]
SHARED = ROOT.parent / "shared" / "data"


@pytest.fixture(scope="session")
def demo():
    """Results of the shipped flight."""
    return db.run(db.Session.load("builtin:demo"))


def shared(path: str) -> pathlib.Path:
    """A file of the reference recordings; the test is skipped where it is absent, and fails under CI=true."""
    found = SHARED / path
    if not found.exists():
        if os.environ.get("CI") == "true":
            pytest.fail(f"{found} is not here")
        pytest.skip(f"{found} is not here")
    return found
