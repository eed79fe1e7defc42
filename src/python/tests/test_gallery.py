"""The gallery of the guide: each script runs, and the page and the pictures show its results.

`python src/python/tests/test_gallery.py` runs all scripts, and writes their pictures and their output into the gallery.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "src" / "guide" / "gallery.md"
GALLERY = ROOT / "src" / "guide" / "gallery"
SCRIPTS = sorted(path.stem for path in GALLERY.glob("*.py"))
DATA = Path(os.environ.get("SEPTET_DATA", ROOT / "tests" / "data"))
# The largest picture, in bytes, and its width.
MOST, WIDTH = 60_000, 640


def run(name: str, picture: Path) -> str:
    """Runs a script and returns its output."""
    call = [sys.executable, str(GALLERY / f"{name}.py"), str(picture)]
    done = subprocess.run(call, capture_output=True, text=True, check=False, timeout=300, cwd=picture.parent,
                          env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0, done.stderr
    return done.stdout


def section(name: str) -> str:
    """Returns the part of the page with the picture of a script."""
    found = [part for part in PAGE.read_text().split("\n## ") if f"(gallery/{name}.png)" in part]
    assert len(found) == 1, f"the page needs one section with gallery/{name}.png"
    return found[0]


def fenced(text: str, language: str) -> str:
    """Returns the only code block of a language."""
    found: "list[str]" = re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert len(found) == 1, f"the section needs one block of {language}"
    return found[0]


def pixels(path: Path) -> Any:
    """Returns the colours of a picture."""
    return np.asarray(imread(path))[..., :3]


def test_gallery_is_complete() -> None:
    assert len(SCRIPTS) == 7
    assert sorted(path.stem for path in GALLERY.glob("*.png")) == SCRIPTS
    assert sorted(re.findall(r"\(gallery/(\w+)\.png\)", PAGE.read_text())) == SCRIPTS


@pytest.mark.parametrize("name", SCRIPTS)
def test_script_runs(name: str, tmp_path: Path) -> None:
    if name == "scan":
        assert (DATA / "bunny00.off").exists(), f"{DATA} has no scan; run tests/run --data, or set SEPTET_DATA"
    output = run(name, tmp_path / "picture.png")
    assert re.search(r"\d", output) and output == fenced(section(name), "text")
    assert [path.name for path in tmp_path.iterdir()] == ["picture.png"]
    made, kept = pixels(tmp_path / "picture.png"), pixels(GALLERY / f"{name}.png")
    assert made.shape[1] == WIDTH and made.std() > 0.05
    assert made.shape == kept.shape and np.abs(made - kept).mean() < 0.02


@pytest.mark.parametrize("name", SCRIPTS)
def test_files_are_short(name: str) -> None:
    script = (GALLERY / f"{name}.py").read_text()
    assert len(script.splitlines()) < 80
    assert (GALLERY / f"{name}.png").stat().st_size <= MOST
    # The page shows passages of the script.
    for passage in fenced(section(name), "python").strip().split("\n\n"):
        assert passage in script, passage


def write() -> None:
    """Writes the pictures, in few colours, and the output of all scripts."""
    from PIL import Image

    for name in SCRIPTS:
        with tempfile.TemporaryDirectory() as folder:
            output = run(name, Path(folder) / "picture.png")
            picture = Image.open(Path(folder) / "picture.png").convert("RGB")
        picture.quantize(96, dither=Image.Dither.NONE).save(GALLERY / f"{name}.png", optimize=True)
        if PAGE.exists():
            old = section(name)
            new = old.replace(f"```text\n{fenced(old, 'text')}```", f"```text\n{output}```")
            PAGE.write_text(PAGE.read_text().replace(old, new))
        print(output)


if __name__ == "__main__":
    write()
