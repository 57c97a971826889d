# SPDX-License-Identifier: MIT
"""`pip install ./bindings/python` into a fresh environment builds the library and works; so does the wheel in another
one, away from the sources. The version is the header's."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = os.environ["DQA_ROOT"]
SOURCES = os.path.join(ROOT, "bindings", "python")
FOLDER = os.path.join(os.environ["DQA_PYTHON_FOLDER"], "wheel")
UNREACHABLE = re.compile(r"name resolution|NewConnectionError|Connection refused|ConnectTimeout|Network is unreachable|"
                         r"ProxyError|Max retries exceeded|Read timed out")
PROGRAM = """
import diffaqua, numpy, sys
space = diffaqua.ShapeSpace(dims=2, cells_x=20, cells_y=8)
space.add_polygon([[0.5, 0.0], [0.1, 0.12], [-0.5, 0.03], [-0.5, -0.03], [0.1, -0.12]], "kite")
simulator = diffaqua.Simulator(space.build())
simulator.set_weights([1.0])
tape = diffaqua.Tape(simulator)
simulator.rollout(diffaqua.Sinusoid(1), 3, tape)
assert numpy.isfinite(tape.gradient(diffaqua.ObjectiveTerm(), diffaqua.Wrt.CONTROL)[0]).all()
print(diffaqua.__version__, diffaqua.library_path)
"""


def run(*command, where="."):
    """Without anything that would lead to the sources or the build."""
    values = {name: value for name, value in os.environ.items() if name not in ("DIFFAQUA_LIBRARY", "PYTHONPATH")}
    values.setdefault("CMAKE_GENERATOR", "Ninja")
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, cwd=where,
                          env=values)
    if done.returncode and UNREACHABLE.search(done.stdout):
        print("skipped: the package registry cannot be reached")
        os._exit(77)
    if done.returncode:
        raise AssertionError(done.stdout[-4000:])
    return done.stdout


def fresh(name):
    """The interpreter of a new environment that sees no other packages."""
    place = os.path.join(FOLDER, name)
    shutil.rmtree(place, ignore_errors=True)
    run(sys.executable, "-m", "venv", place)
    return os.path.join(place, "bin", "python")


def version():
    with open(os.path.join(ROOT, "capi", "diffaqua.h"), encoding="utf-8") as file:
        return ".".join(re.findall(r"#define DQA_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", file.read()))


class Wheel(unittest.TestCase):
    build = "--config-settings=build-dir=" + os.path.join(FOLDER, "build")

    def works(self, python):
        with tempfile.TemporaryDirectory() as elsewhere:
            found, library = run(python, "-c", PROGRAM, where=elsewhere).split()
        self.assertEqual(found, version())
        environment = os.path.realpath(os.path.dirname(os.path.dirname(python)))
        self.assertTrue(os.path.realpath(library).startswith(environment))

    def test_from_sources_then_as_wheel(self):
        python = fresh("sources")
        run(python, "-m", "pip", "install", self.build, SOURCES)
        self.works(python)
        wheels = os.path.join(FOLDER, "wheels")
        shutil.rmtree(wheels, ignore_errors=True)
        run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", self.build, "-w", wheels,
            SOURCES)
        name, = os.listdir(wheels)
        self.assertRegex(name, rf"^diffaqua-{re.escape(version())}-py3-none-linux_\w+\.whl$")
        with zipfile.ZipFile(os.path.join(wheels, name)) as wheel:
            names = set(wheel.namelist())
        self.assertLessEqual({"diffaqua/libdiffaqua.so", "diffaqua/diffaqua.cdef", "diffaqua/py.typed"}, names)
        self.assertEqual([entry for entry in names if not re.match(r"diffaqua(-[\d.]+\.dist-info)?/", entry)], [])
        python = fresh("elsewhere")
        run(python, "-m", "pip", "install", os.path.join(wheels, name))
        self.works(python)
        self.assertIn("diffaqua", run(python, "-m", "pip", "uninstall", "-y", "diffaqua"))


if __name__ == "__main__":
    unittest.main(verbosity=1)
