"""Puts the program into the wheel: the one that PIAD_WHEEL_PROGRAM names. Without it the wheel is pure Python."""

from __future__ import annotations

import os
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class WithProgram(BuildHookInterface):  # type: ignore[type-arg]
    """The build of a wheel for one platform, which serves all versions of Python."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Adds the program to the scripts, which installers make executable, and the licences of both."""
        program = os.environ.get("PIAD_WHEEL_PROGRAM")
        if self.target_name != "wheel" or version != "standard" or not program:
            return
        # A static program runs on more systems than the one that it is built on: PIAD_WHEEL_PLATFORM names these.
        platform = os.environ.get("PIAD_WHEEL_PLATFORM") or sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
        build_data["shared_scripts"][program] = Path(program).name
        for name in ("LICENSE-APACHE", "LICENSE-MIT"):
            build_data["force_include"][str(Path(self.root, "../..", name))] = f"piad/{name}"
