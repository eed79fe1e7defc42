"""Lists the licences of the crates that the wheel contains, from `cargo metadata`."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Dict, List, Set

ROOT = Path(__file__).resolve().parents[2]
ROOTS = ("septet", "septet-python")
# Code of other projects that crates of the workspace contain.
VENDORED = {"three.js 0.180.0": ("MIT", ROOT / "src/cli/page/assets/three/LICENSE")}


def crates() -> List[Dict[str, Any]]:
    """Returns the packages that the module and the program link, by name."""
    version = subprocess.run(["rustc", "-vV"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    host = next(line.split()[1] for line in version.splitlines() if line.startswith("host:"))
    command = [os.environ.get("CARGO", "cargo"), "metadata", "--format-version", "1", "--locked", "--filter-platform", host]
    found = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    seen: Set[str] = set()
    waiting = [id for id in found["workspace_members"] if packages[id]["name"] in ROOTS]
    while waiting:
        id = waiting.pop()
        if id in seen:
            continue
        seen.add(id)
        for dependency in nodes[id]["deps"]:
            # A dependency of tests or of build scripts is not in the wheel.
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    return sorted((packages[id] for id in seen), key=lambda p: (p["name"], p["version"]))


def text() -> str:
    """Returns the list, followed by the texts of the licences, each once."""
    lines, texts = ["The wheel contains these crates:", ""], {}  # type: List[str], Dict[str, List[str]]
    for package in crates():
        name = f"{package['name']} {package['version']}"
        if not package["license"] and not package["license_file"]:
            raise SystemExit(f"{name} states no licence")
        lines.append(f"{name}: {package['license'] or package['license_file']}")
        folder = Path(package["manifest_path"]).parent
        for file in sorted(folder.iterdir()):
            if file.is_file() and file.suffix != ".py" and file.name.upper().startswith(("LICENSE", "LICENCE", "COPYING", "NOTICE")):
                texts.setdefault(file.read_text(encoding="utf-8", errors="replace").strip(), []).append(name)
    lines += ["", "and code of other projects:", ""]
    for name, (licence, file) in VENDORED.items():
        lines.append(f"{name}: {licence}")
        texts.setdefault(file.read_text(encoding="utf-8").strip(), []).append(name)
    for licence, names in texts.items():
        lines += ["", "=" * 80, ", ".join(names), "=" * 80, "", licence]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(text(), end="")
