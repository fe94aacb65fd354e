"""All packages and the server are of one version, that of Cargo.toml."""

from __future__ import annotations

import re
from importlib.metadata import version

import pytest
from conftest import ROOT

import piad

MANIFESTS = {
    "Cargo.toml": r'^version = "(.+)"$',
    "clients/python/pyproject.toml": r'^version = "(.+)"$',
    "clients/typescript/package.json": r'^  "version": "(.+)",$',
    "clients/freecad/package.xml": r"<version>(.+)</version>",
    "clients/cpp/CMakeLists.txt": r"^project\(piad VERSION (\S+)",
}


@pytest.mark.parametrize("manifest", MANIFESTS)
def test_versions_are_equal(manifest: str) -> None:
    said = re.search(MANIFESTS[manifest], (ROOT / manifest).read_text(encoding="utf-8"), re.M)
    assert said and piad.__version__ == version("piad") == said[1]


def test_the_server_has_the_same(client: piad.Client) -> None:
    assert client.capabilities()["version"] == piad.__version__
