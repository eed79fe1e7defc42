"""Files of points that other programs write, and the points that septet must read from them.

    python tests/foreign/files_of_others.py tests/reports/made

Needs numpy, pandas, meshio, pyvista, gmsh and laspy[lazrs]. Each file is written by a real program from known points. The
folder also gets `cases.json`, with the points of each file, or the pattern of the refusal that names its reason. A test of
septet-io reads all files of the folder.
"""

import json
import os
import sys

import gmsh
import laspy
import meshio
import numpy as np
import pandas as pd
import pyvista as pv

rng = np.random.default_rng(7)
XYZ = np.round(rng.random((12, 3)), 4)
XY = XYZ[:, :2].copy()
CASES = []


def case(name, right, *args):
    """Declares a file: `right` is an array of points, the pattern of a refusal, or both, or None for the points made."""

    def declare(make):
        CASES.append((name, right, args, make))
        return make

    return declare


def frame(names="xyz", points=XYZ, **others):
    data = {name: points[:, i] for i, name in enumerate(names)}
    return pd.DataFrame({**others, **data})


IDS = np.arange(1, 13)
TEXTS = [f"BH {i}" for i in IDS]

# pandas
case("pandas-plain.csv", XYZ)(lambda p: frame().to_csv(p, index=False))
case("pandas-index.csv", XYZ)(lambda p: frame().to_csv(p))
case("pandas-tab.txt", XYZ)(lambda p: frame().to_csv(p, sep="\t"))
case("pandas-tab-names.txt", XYZ)(lambda p: frame(name=TEXTS).to_csv(p, sep="\t", index=False))
case("pandas-tab-missing.txt", XYZ)(lambda p: frame(q=[None, 1.5] * 6).to_csv(p, sep="\t", index=False))
case("pandas-escaped-missing.txt", XYZ)(
    lambda p: frame(q=[None, 1.5] * 6)[["x", "q", "y", "z"]].to_csv(p, sep=" ", index=False, na_rep=" ", quoting=3, escapechar="\\"))
case("pandas-semicolon-comma.csv", XYZ)(lambda p: frame().to_csv(p, sep=";", decimal=",", index=False))
case("pandas-semicolon-comma-index.csv", XYZ)(lambda p: frame().to_csv(p, sep=";", decimal=","))
case("pandas-tab-comma.txt", "decimal comma")(lambda p: frame().to_csv(p, sep="\t", decimal=",", index=False))
case("pandas-comma-comma.csv", "decimal comma")(lambda p: frame().to_csv(p, decimal=",", index=False))
case("pandas-quoted.csv", XYZ)(lambda p: frame(name=['a, "b"'] * 12).to_csv(p, index=False, quoting=1))
case("pandas-lat-lon.csv", XY)(lambda p: frame(["longitude", "latitude"], XY)[["latitude", "longitude"]].to_csv(p, index=False))
case("pandas-easting.csv", XYZ)(
    lambda p: frame(["Easting", "Northing", "Elevation"])[["Northing", "Easting", "Elevation"]].to_csv(p, index=False))
case("pandas-id-lon-lat.csv", XY)(lambda p: frame(["lon", "lat"], XY, station=IDS).to_csv(p, index=False))
case("pandas-time.csv", XY)(lambda p: frame(["lon", "lat"], XY, time=pd.date_range("2024-01-01", periods=12)).to_csv(p, index=False))
case("pandas-other-names.csv", "--columns")(lambda p: frame("abc").to_csv(p, index=False))
case("pandas-other-names-chosen.csv", XYZ, "--columns", "c,d,e")(lambda p: frame("cde", id=IDS).to_csv(p, index=False))
case("pandas-no-header.csv", XYZ)(lambda p: frame().to_csv(p, index=False, header=False))
case("pandas-no-header-index.csv", ("--columns 2,3,4", XYZ))(lambda p: frame().to_csv(p, header=False))
case("pandas-utf16.csv", XYZ)(lambda p: frame().to_csv(p, index=False, encoding="utf-16"))
case("pandas-bom.csv", XYZ)(lambda p: frame().to_csv(p, index=False, encoding="utf-8-sig"))
case("pandas-latin1.csv", XYZ)(lambda p: frame(ort=["Zürich"] * 12).to_csv(p, index=False, encoding="latin-1"))
case("pandas-float-format.csv", XYZ)(lambda p: frame().to_csv(p, index=False, float_format="%.4e"))
case("pandas-missing.csv", "empty")(lambda p: frame(points=np.where(XYZ > 0.95, np.nan, XYZ)).to_csv(p, index=False))
case("pandas-gz.csv.gz", XYZ)(lambda p: frame().to_csv(p, index=False))
case("pandas-bz2.csv.bz2", "bunzip2")(lambda p: frame().to_csv(p, index=False))
case("pandas-json.json", "JSON")(lambda p: frame().to_json(p))
case("pandas-string.txt", XYZ)(lambda p: open(p, "w").write(frame().to_string()))
case("pandas-string-no-index.txt", XYZ)(lambda p: open(p, "w").write(frame().to_string(index=False)))

# numpy
case("savetxt.txt", XYZ)(lambda p: np.savetxt(p, XYZ))
case("savetxt-header.txt", XYZ)(lambda p: np.savetxt(p, XYZ[:, ::-1], header="z y x"))
case("savetxt-header-csv.csv", XYZ)(lambda p: np.savetxt(p, XYZ[:, ::-1], header="z,y,x", delimiter=","))
case("savetxt-header-id.txt", XY)(lambda p: np.savetxt(p, np.column_stack([IDS, XY]), header="id x y"))
case("savetxt-ids.txt", ("--columns 2,3,4", XYZ))(lambda p: np.savetxt(p, np.column_stack([IDS, XYZ]), fmt=["%d"] + ["%.4f"] * 3))
case("savetxt-transposed.npy", r"\(3, 12\).*a\.T")(lambda p: np.save(p, XYZ.T))
case("big-endian.npy", XYZ)(lambda p: np.save(p, XYZ.astype(">f8")))
case("big-endian-fortran.npy", XYZ)(lambda p: np.save(p, np.asfortranarray(XYZ.astype(">f8"))))
case("float32.npy", XYZ.astype("f4").astype("f8"))(lambda p: np.save(p, XYZ.astype("f4")))
case("structured.npy", XYZ)(lambda p: np.save(p, np.array(
    [(i, *row, "a") for i, row in zip(IDS, XYZ)], dtype=[("id", "<i4"), ("x", "<f8"), ("y", ">f8"), ("z", "<f8"), ("n", "U3")])))
case("record-array.npy", XY)(lambda p: np.save(p, frame(["lon", "lat"], XY, id=IDS).to_records(index=False)))
case("structured-names.npy", "a, b")(lambda p: np.save(p, np.zeros(4, dtype=[("a", "<f8"), ("b", "<f8")])))
case("homogeneous.npy", r"\(12, 4\)")(lambda p: np.save(p, np.column_stack([XYZ, np.ones(12)])))
case("one.npz", XYZ)(lambda p: np.savez(p, XYZ))
case("compressed.npz", XYZ)(lambda p: np.savez_compressed(p, points=XYZ, cells=np.arange(8)))
case("several.npz", "a, b")(lambda p: np.savez(p, a=XYZ, b=XYZ))
case("half.npy", "type")(lambda p: np.save(p, XYZ.astype("f2")))

# PyVista and VTK
CLOUD = pv.PolyData(XYZ)
case("pyvista-cloud.vtk", XYZ)(lambda p: CLOUD.save(p))
case("pyvista-cloud-ascii.vtk", XYZ)(lambda p: CLOUD.save(p, binary=False))
case("pyvista-cloud.vtp", XYZ)(lambda p: CLOUD.save(p))
case("pyvista-cloud-ascii.vtp", XYZ)(lambda p: CLOUD.save(p, binary=False))


def with_arrays():
    cloud = CLOUD.copy()
    cloud["pressure"] = np.arange(12.0)
    cloud["table"] = IDS.astype("i8")
    cloud.field_data["note"] = ["a b"]
    return cloud


case("pyvista-arrays.vtk", XYZ)(lambda p: with_arrays().save(p))
case("pyvista-arrays.vtp", XYZ)(lambda p: with_arrays().save(p))
SURFACE = pv.PolyData(XYZ).delaunay_2d()
case("pyvista-surface.vtk", XYZ)(lambda p: SURFACE.save(p))
case("pyvista-surface.vtp", XYZ)(lambda p: SURFACE.save(p))
case("pyvista-surface.ply", XYZ.astype("f4").astype("f8"))(lambda p: SURFACE.save(p))
GRID = pv.PolyData(XYZ).delaunay_3d()
case("pyvista-grid.vtu", np.asarray(GRID.points, dtype="f8"))(lambda p: GRID.save(p))
case("pyvista-grid.vtk", np.asarray(GRID.points, dtype="f8"))(lambda p: GRID.save(p))
case("pyvista-image.vti", "ImageData")(lambda p: pv.ImageData(dimensions=(3, 3, 3)).save(p))

# meshio
CELLS = [("tetra", np.array([[0, 1, 2, 3], [4, 5, 6, 7]])), ("triangle", np.array([[8, 9, 10], [9, 10, 11]]))]
MESH = meshio.Mesh(XYZ, CELLS)
for name, options in [
    ("gmsh.msh", {"file_format": "gmsh"}), ("gmsh22.msh", {"file_format": "gmsh22"}), ("gmsh22-ascii.msh", {"file_format": "gmsh22", "binary": False}),
    ("gmsh-ascii.msh", {"file_format": "gmsh", "binary": False}), ("grid.vtu", {}), ("grid-ascii.vtu", {"binary": False}),
    ("grid.vtk", {}), ("grid42.vtk", {"file_format": "vtk42"}), ("medit.mesh", {}), ("points.ply", {}), ("points.obj", {}),
]:
    def write(path, options=options, name=name):
        # meshio writes version 4.1 of cells of one kind only.
        kinds = CELLS[1:] if name.endswith((".obj", ".ply")) else CELLS[:1] if name.startswith("gmsh") else CELLS
        mesh = meshio.Mesh(XYZ, kinds)
        meshio.write(path, mesh, **options)
    case(f"meshio-{name}", XYZ)(write)
case("meshio.off", XYZ)(lambda p: meshio.write(p, meshio.Mesh(XYZ, CELLS[1:])))
case("meshio.stl", XYZ[8:])(lambda p: meshio.write(p, meshio.Mesh(XYZ, CELLS[1:])))
case("meshio.inp", "meshio")(lambda p: meshio.write(p, MESH, file_format="abaqus"))
case("meshio.su2", "meshio")(lambda p: open(p, "w").write("NDIME= 3\n"))


# Gmsh
def gmsh_file(path, version, binary):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.Binary", binary)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], name="box")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.9)
    gmsh.model.mesh.generate(3)
    gmsh.write(path)
    _, found, _ = gmsh.model.mesh.getNodes()
    gmsh.finalize()
    # Text has 16 digits.
    found = found if binary else [float(f"{c:.16g}") for c in found]
    return np.array(found).reshape(-1, 3)


case("gmsh-41-binary.msh", None)(lambda p: gmsh_file(p, 4.1, 1))
case("gmsh-41-ascii.msh", None)(lambda p: gmsh_file(p, 4.1, 0))
case("gmsh-22-binary.msh", None)(lambda p: gmsh_file(p, 2.2, 1))
case("gmsh-22-ascii.msh", None)(lambda p: gmsh_file(p, 2.2, 0))


# laspy
def scan(path, point_format=3, version="1.2"):
    header = laspy.LasHeader(point_format=point_format, version=version)
    header.offsets = np.array([100.0, 200.0, 0.0])
    header.scales = np.array([0.001, 0.001, 0.01])
    las = laspy.LasData(header)
    las.x, las.y, las.z = XYZ[:, 0] + 100, XYZ[:, 1] + 200, XYZ[:, 2]
    las.write(path)
    return np.column_stack([np.asarray(las.x), np.asarray(las.y), np.asarray(las.z)])


case("laspy-12.las", None)(scan)
case("laspy-14.las", None)(lambda p: scan(p, 6, "1.4"))
case("laspy-12.laz", None)(scan)
case("laspy-14.laz", None)(lambda p: scan(p, 6, "1.4"))


def main(folder):
    os.makedirs(folder, exist_ok=True)
    sets, cases = {}, []
    for name, right, args, make in CASES:
        path = os.path.join(folder, name)
        made = make(path)
        if right is None:
            right = made if isinstance(made, np.ndarray) else np.unique(np.asarray(pv.read(path).points, dtype="f8"), axis=0)
        outcomes = []
        for one in right if isinstance(right, tuple) else (right,):
            if isinstance(one, str):
                outcomes.append({"refuse": one})
            else:
                outcomes.append({"points": name})
                sets[name] = (np.asarray(one, dtype="f8") + 0.0).tolist()
        cases.append({"name": name, "file": name, "args": list(args), "right": outcomes})
    with open(os.path.join(folder, "cases.json"), "w") as out:
        sets = ",\n".join(f"{json.dumps(name)}: {json.dumps(rows)}" for name, rows in sets.items())
        cases = ",\n".join(json.dumps(case) for case in cases)
        out.write(f'{{"sets": {{\n{sets}\n}},\n"cases": [\n{cases}\n]}}\n')


if __name__ == "__main__":
    main(sys.argv[1])
