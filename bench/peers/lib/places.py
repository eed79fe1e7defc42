"""Paths of files and directories."""
import pathlib

HERE = pathlib.Path(__file__).resolve().parent.parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "peers"
PYTHON = ROOT / "target" / "venv" / "bin" / "python"
SEPTET = ROOT / "target" / "release" / "septet"
MESHES = ROOT / "tests" / "data"
