#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The virtual environment of the Python tests: made once inside the build folder, where everything that pip and the
tests write stays as well.

    environment.py FOLDER --make             installs requirements.txt, unless it is there; 77 without a registry
    environment.py FOLDER TEST [ARGUMENTS]   runs a test with it; 77 when it could not be made
"""
import hashlib
import os
import re
import shutil
import site
import subprocess
import sys
import sysconfig
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.abspath(os.path.join(HERE, "..", "..", ".."))
REQUIREMENTS = os.path.join(HERE, "requirements.txt")
SKIP = 77
UNREACHABLE = re.compile(r"name resolution|NewConnectionError|Connection refused|ConnectTimeout|Network is unreachable|"
                         r"ProxyError|Max retries exceeded|Read timed out")


def interpreter():
    """Debian's own where it has PyTorch, else the one that runs this."""
    debian = "/usr/bin/python3"
    if os.path.exists(debian) and not subprocess.run([debian, "-c", "import torch"], capture_output=True, check=False
                                                     ).returncode:
        return debian
    return sys.executable


def environment(folder):
    """Variables that keep caches, settings and temporary files inside the folder."""
    values = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    for name, place in (("HOME", "home"), ("XDG_CACHE_HOME", "cache"), ("XDG_CONFIG_HOME", "config"),
                        ("XDG_DATA_HOME", "data"), ("PIP_CACHE_DIR", "pip"), ("TMPDIR", "tmp"),
                        ("MPLCONFIGDIR", "matplotlib"), ("DASK_TEMPORARY_DIRECTORY", "dask")):
        values[name] = os.path.join(folder, place)
        os.makedirs(values[name], exist_ok=True)
    values["PYTHONPYCACHEPREFIX"] = os.path.join(folder, "bytecode")
    values["PYTHONNOUSERSITE"] = "1"
    values["PIP_DISABLE_PIP_VERSION_CHECK"] = "1"
    values["PATH"] = os.path.join(folder, "env", "bin") + os.pathsep + values.get("PATH", "")
    if "CCACHE_DIR" not in values and "HOME" in os.environ:  # the compiler's cache is that of the build
        values["CCACHE_DIR"] = subprocess.run(["ccache", "--get-config", "cache_dir"], capture_output=True, text=True,
                                              check=False).stdout.strip() if shutil.which("ccache") else ""
    return {name: value for name, value in values.items() if value}  # an empty compiler launcher is an error


def outside():
    """What installing and testing could leave outside of the folder: packages of the interpreters and of the user, and
    in the sources whatever builds and caches are called."""
    installed = {site.getusersitepackages(), sysconfig.get_path("purelib"), "/usr/lib/python3/dist-packages"}
    left = re.compile(r"__pycache__|.*\.(egg-info|dist-info|so|whl)|dist|_skbuild|\.\w+_cache")
    found = {place: sorted(os.listdir(place)) for place in installed if os.path.isdir(place)}
    for sources in ("bindings", "tests/bindings"):
        for where, folders, names in os.walk(os.path.join(ROOT, sources)):
            found[where] = sorted(name for name in folders + names if left.fullmatch(name))
    return {place: names for place, names in found.items() if names}


def run_pip(folder, *arguments):
    done = subprocess.run([os.path.join(folder, "env", "bin", "python"), "-m", "pip", *arguments],
                          env=environment(folder), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    if done.returncode:
        print(done.stdout[-4000:])
        if UNREACHABLE.search(done.stdout):
            print("skipped: the package registry cannot be reached")
            sys.exit(SKIP)
        sys.exit("pip failed")


def size(folder):
    return sum(os.lstat(os.path.join(where, name)).st_size for where, _, names in os.walk(folder) for name in names)


def make(folder):
    base = interpreter()
    with open(REQUIREMENTS, "rb") as file:
        wanted = hashlib.sha256(file.read() + base.encode()).hexdigest()
    stamp = os.path.join(folder, "stamp")
    if os.path.exists(stamp):
        with open(stamp, encoding="utf-8") as file:
            if file.read() == wanted:
                print("the environment is there")
                return
    before, started = outside(), time.monotonic()
    shutil.rmtree(os.path.join(folder, "env"), ignore_errors=True)
    os.makedirs(folder, exist_ok=True)
    subprocess.run([base, "-m", "venv", "--system-site-packages", os.path.join(folder, "env")], check=True,
                   env=environment(folder))
    run_pip(folder, "install", "-q", "--no-compile", "-r", REQUIREMENTS)
    after = outside()
    if before != after:
        changed = [place for place in after if before.get(place) != after[place]]
        sys.exit(f"installing changed what lies outside of the build folder: {changed}")
    with open(stamp, "w", encoding="utf-8") as file:
        file.write(wanted)
    print(f"made in {time.monotonic() - started:.0f} s, {size(os.path.join(folder, 'env')) / 1e6:.0f} MB, "
          "nothing outside of the build folder")


def run(folder, test, arguments):
    python = os.path.join(folder, "env", "bin", "python")
    if not os.path.exists(os.path.join(folder, "stamp")):
        print("skipped: the environment is not there (bindings/python_environment makes it)")
        return SKIP
    values = environment(folder)
    values["PYTHONPATH"] = os.pathsep.join([os.path.join(ROOT, "bindings", "python", "src"), HERE])
    values["DQA_PYTHON_FOLDER"] = folder
    before = outside()
    code = subprocess.run([python, test, *arguments], env=values, check=False,
                          cwd=os.path.join(folder, "tmp")).returncode
    if outside() != before:
        print("the test left something outside of the build folder")
        return 1
    return code


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__.strip())
    folder = os.path.abspath(sys.argv[1])
    if sys.argv[2] == "--make":
        make(folder)
        return 0
    return run(folder, sys.argv[2], sys.argv[3:])


if __name__ == "__main__":
    sys.exit(main())
