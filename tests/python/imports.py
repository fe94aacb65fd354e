"""Checks that files and folders of the Python and TypeScript packages have no circular imports."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[2]
PYTHON = ("clients/python/src/piad", "clients/freecad/freecad/piad_workbench")
TYPESCRIPT = ("clients/typescript/src", "viewer/src")


def python_imports(file: Path) -> Iterator[Path]:
    """The files that relative imports of a Python file name; a name of a package is in its `__init__.py`."""
    for node in ast.walk(ast.parse(file.read_text())):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
        for name in node.names:
            found = (base / f"{name.name}.py", base / name.name / "__init__.py", base.with_suffix(".py"), base / "__init__.py")
            yield next(path for path in found if path.exists())


def typescript_imports(file: Path) -> Iterator[Path]:
    """The files that relative imports of a TypeScript file name."""
    for name in re.findall(r'(?:from|import)\s+"(\.[^"]+)\.js"', file.read_text()):
        yield (file.parent / f"{name}.ts").resolve()


def check(graph: dict[str, set[str]], what: str) -> None:
    """Fails if there is a cycle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise SystemExit(f"{what} import each other in a circle: {' <- '.join(error.args[1])}") from None


for folder in PYTHON + TYPESCRIPT:
    root = ROOT / folder
    ending, imports = ("py", python_imports) if folder in PYTHON else ("ts", typescript_imports)
    names = {file: str(file.relative_to(root)) for file in root.rglob(f"*.{ending}")}
    files = {name: {names[used] for used in imports(file) if used in names} for file, name in names.items()}
    assert sum(map(len, files.values())) > len(files), f"nothing is read in {folder}"
    check(files, f"files of {folder}")
    folders: dict[str, set[str]] = {}
    for user, all_used in files.items():
        top = user.split("/")[0]
        folders.setdefault(top, set()).update(used.split("/")[0] for used in all_used if used.split("/")[0] != top)
    check(folders, f"folders of {folder}")
