#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The frames of codesign as VTK itself reads them: test_report_vtk.py PROGRAM compares them with design.stl, with the
summary and with the reader of the other tests. Skipped (exit code 77) where VTK's Python modules are missing."""
import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import results

try:
    from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkMassProperties
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
    from vtkmodules.vtkIOGeometry import vtkSTLReader
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    VTK = True
except ImportError:
    VTK = False

SMALL = ["--grid", "24x10x12", "--steps", "6", "--iterations", "1"]


def read(path):
    """The grid of a frame; any complaint of VTK is an error here."""
    reader, complaints = vtkXMLUnstructuredGridReader(), []
    for event in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(event, lambda *_: complaints.append(path))
    reader.SetFileName(path)
    reader.Update()
    assert not complaints, f"VTK complains about {path}"
    return reader.GetOutput()


def rows(array):
    return [array.GetTuple(i) for i in range(array.GetNumberOfTuples())]


def surface_of(grid):
    surface = vtkGeometryFilter()
    surface.SetInputData(grid)
    surface.Update()
    return surface.GetOutput()


def volume(surface):
    mass = vtkMassProperties()
    mass.SetInputData(surface)
    return mass.GetVolume()


def open_edges(surface):
    edges = vtkFeatureEdges()
    edges.SetInputData(surface)
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def main(program):
    with tempfile.TemporaryDirectory(prefix="vtk-") as out:
        process = results.run(program, *SMALL, "--out", out)
        assert process.returncode == 0, process.stderr
        index = ElementTree.parse(os.path.join(out, "swimmer.pvd")).getroot()
        sets = [(float(e.get("timestep")), os.path.join(out, e.get("file"))) for e in index.iter("DataSet")]
        settings = results.read_summary(out)["settings"]
        assert len(sets) == settings["steps"] + 1
        rest, before = read(sets[0][1]), None
        stl = vtkSTLReader()
        stl.SetFileName(os.path.join(out, "design.stl"))
        stl.Update()
        assert stl.GetOutput().GetNumberOfCells() == rest.GetNumberOfCells()
        assert all(abs(a - b) < 1e-6 for a, b in zip(stl.GetOutput().GetBounds(), rest.GetBounds()))
        assert open_edges(surface_of(rest)) == 0, "the surface is open"
        volumes = []
        for k, (when, path) in enumerate(sets):
            assert abs(when - k * settings["time_step"]) < 1e-6, f"frame {k} is at {when} s"
            grid, own = read(path), results.read_vtu(path)
            assert grid.GetNumberOfPoints() == rest.GetNumberOfPoints() == len(own["Points"]) // 3
            assert grid.GetNumberOfCells() == rest.GetNumberOfCells() == len(own["types"])
            points = rows(grid.GetPoints().GetData())
            assert [x for row in points for x in row] == list(own["Points"])
            data = grid.GetPointData()
            assert data.GetVectors().GetName() == "displacement"
            displacement, velocity = (rows(data.GetArray(name)) for name in ("displacement", "velocity"))
            for x, x0, u in zip(points, rows(rest.GetPoints().GetData()), displacement):
                assert all(abs(a - b - c) < 1e-6 for a, b, c in zip(x, x0, u))
            for x, x0, v in zip(points, before or points, velocity):
                assert all(abs(a - b - settings["time_step"] * c) < 1e-6 for a, b, c in zip(x, x0, v))
            before = points
            volumes.append(volume(surface_of(grid)))
        print(f"{len(sets)} frames of {rest.GetNumberOfPoints()} points and {rest.GetNumberOfCells()} triangles; "
              f"volume {volumes[0]:.6f} ... {volumes[-1]:.6f} m^3")
        assert min(volumes) > 0.0 and max(volumes) < 1.2 * min(volumes)
        assert max(abs(x) for row in displacement for x in row) > 1e-5, "the swimmer does not move"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: test_report_vtk.py PROGRAM")
    if not VTK:
        print("skipped: VTK's Python modules are not installed")
        sys.exit(77)
    main(os.path.abspath(sys.argv[1]))
