"""Packs the module, the package and the program `septet` as a wheel: a zip file with a list of its contents."""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path
from typing import Any, Dict, List, Tuple

import licences

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# The largest wheel, in bytes. The program takes 11.5 million of them, and the module 7.2 million.
MOST = 24_000_000


def project() -> Dict[str, Any]:
    """Reads the metadata of the package."""
    import tomllib

    with open(HERE / "pyproject.toml", "rb") as file:
        made: Dict[str, Any] = tomllib.load(file)["project"]
    with open(ROOT / "Cargo.toml", "rb") as file:
        made["version"] = tomllib.load(file)["workspace"]["package"]["version"]
    return made


def platform_tag() -> str:
    """Returns the tag of this machine. A program of Linux needs at least the C library that it was linked with."""
    machine = platform.machine()
    if sys.platform == "linux":
        name, version = platform.libc_ver()
        if name == "glibc":
            return "manylinux_" + "_".join(version.split(".")[:2]) + "_" + machine
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def metadata(of: Dict[str, Any]) -> str:
    """Returns the file METADATA."""
    lines = [
        "Metadata-Version: 2.4",
        f"Name: {of['name']}",
        f"Version: {of['version']}",
        f"Summary: {of['description']}",
        f"Keywords: {','.join(of['keywords'])}",
        *[f"Classifier: {classifier}" for classifier in of["classifiers"]],
        f"License-Expression: {of['license']}",
        "License-File: LICENSE-APACHE",
        "License-File: LICENSE-MIT",
        "License-File: CRATES.txt",
        *[f"Requires-Dist: {dependency}" for dependency in of["dependencies"]],
        f"Requires-Python: {of['requires-python']}",
        "Description-Content-Type: text/markdown",
        "",
        (HERE / of["readme"]).read_text(encoding="utf-8"),
    ]
    return "\n".join(lines)


def stripped(file: Path, folder: Path) -> bytes:
    """Returns a program or module without its symbols."""
    copy = folder / file.name
    shutil.copy2(file, copy)
    if shutil.which("strip"):
        subprocess.run(["strip", str(copy)], check=True)
    return copy.read_bytes()


def contents(target: Path, tag: str) -> Tuple[str, List[Tuple[str, bytes, int]]]:
    """Returns the name of the wheel and its files with their modes."""
    of = project()
    base = f"{of['name']}-{of['version']}"
    whole = f"{tag}-{platform_tag()}"
    info = f"{base}.dist-info"
    files = [(f"septet/{path.name}", path.read_bytes(), 0o644) for path in sorted((HERE / "septet").glob("*.py*"))]
    files.append(("septet/py.typed", b"", 0o644))
    suffix = {"win32": "pyd"}.get(sys.platform, "so")
    library = {"darwin": "lib_septet.dylib", "win32": "_septet.dll"}.get(sys.platform, "lib_septet.so")
    module = "septet/_septet." + (f"abi3.{suffix}" if tag.endswith("abi3") else suffix)
    program = "septet.exe" if sys.platform == "win32" else "septet"
    with tempfile.TemporaryDirectory() as folder:
        files.append((module, stripped(target / "release" / library, Path(folder)), 0o755))
        files.append((f"{base}.data/scripts/{program}", stripped(target / "release" / program, Path(folder)), 0o755))
    wheel = f"Wheel-Version: 1.0\nGenerator: septet\nRoot-Is-Purelib: false\nTag: {whole}\n"
    texts = {"METADATA": metadata(of), "WHEEL": wheel, "licenses/CRATES.txt": licences.text()}
    for name in ("LICENSE-APACHE", "LICENSE-MIT"):
        texts[f"licenses/{name}"] = (ROOT / name).read_text(encoding="utf-8")
    files += [(f"{info}/{name}", text.encode(), 0o644) for name, text in texts.items()]
    record = [f"{name},sha256={digest(data)},{len(data)}" for name, data, _ in files]
    record.append(f"{info}/RECORD,,")
    files.append((f"{info}/RECORD", ("\n".join(record) + "\n").encode(), 0o644))
    return f"{base}-{whole}.whl", files


def digest(data: bytes) -> str:
    """Returns the digest of a file as RECORD writes it."""
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def main() -> None:
    """Writes the wheel."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--target", type=Path, required=True, help="the target folder of cargo")
    parser.add_argument("--tag", required=True, help="the tags of the interpreter and of its interface, as cp39-abi3")
    parser.add_argument("--out", type=Path, required=True, help="the folder of the wheel")
    arguments = parser.parse_args()
    name, files = contents(arguments.target, arguments.tag)
    arguments.out.mkdir(parents=True, exist_ok=True)
    for old in arguments.out.glob(f"septet-*-{arguments.tag}-*.whl"):
        old.unlink()
    path = arguments.out / name
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for file, data, mode in files:
            entry = zipfile.ZipInfo(file, date_time=(1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            out.writestr(entry, data)
    size = path.stat().st_size
    if size > MOST:
        path.unlink()
        raise SystemExit(f"the wheel has {size} bytes, but at most {MOST} are allowed")
    print(json.dumps({"wheel": os.fspath(path), "bytes": size}))


if __name__ == "__main__":
    main()
