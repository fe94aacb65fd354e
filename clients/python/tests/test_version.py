"""The package and the server are of one version."""

from __future__ import annotations

import re
from importlib.metadata import version

import pytest
from conftest import ROOT

import piad


@pytest.mark.parametrize("manifest", ["clients/python/pyproject.toml", "Cargo.toml"])
def test_versions_are_equal(manifest: str) -> None:
    said = re.search(r'^version = "(.+)"$', (ROOT / manifest).read_text(encoding="utf-8"), re.M)
    assert said and piad.__version__ == version("piad") == said[1]


def test_the_server_has_the_same(client: piad.Client) -> None:
    assert client.capabilities()["version"] == piad.__version__
