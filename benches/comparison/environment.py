"""Where the comparison runs: an environment of its own for Python, our program, and what both are."""

import json
import os
import platform
import shutil
import subprocess
import sys
import venv
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGES = ("numpy", "numba", "pin", "cmeel-eigen", "cmeel-boost", "casadi", "mujoco", "pysindy", "matplotlib")


def requirements():
    """The lines of requirements.txt that name a package."""
    lines = (HERE / "requirements.txt").read_text().splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def enter(out):
    """Starts this command again in an environment of its own, which is made first; returns if that is so already.

    Each package is installed by itself, so that one that cannot be had takes no other with it.
    """
    folder = out / "venv"
    if Path(sys.prefix) == folder:
        return
    python, note = folder / "bin/python", folder / "installed.json"
    if not (note.exists() and json.loads(note.read_text()) == requirements()):
        venv.create(folder, with_pip=True, clear=True)
        for requirement in requirements():
            pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", requirement]
            if subprocess.run([str(part) for part in pip], check=False).returncode:
                print(f"{requirement} cannot be installed here", file=sys.stderr)
        note.write_text(json.dumps(requirements()))
    os.execv(python, [str(python), *sys.argv])


def program():
    """Builds our command line."""
    subprocess.run(["cargo", "build", "--release", "--quiet", "--locked", "--package", "eqmotion-cli"], cwd=ROOT, check=True)
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return folder / "release/dynamics"


def first_line(*command):
    """What a program says its version is."""
    if not shutil.which(command[0]) and not Path(command[0]).exists():
        return f"{command[0]} is not there"
    return subprocess.run(command, text=True, capture_output=True, check=False).stdout.splitlines()[0]


def processor():
    """The processor's name, as Linux has it."""
    path = Path("/proc/cpuinfo")
    if path.exists():
        for line in path.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":")[1].strip()
    return platform.processor() or platform.machine()


def installed(name):
    """A package's version."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def report(ours, flags, rustflags, crate):
    """Versions and flags, line by line."""
    return [
        f"ours: {first_line(str(ours), '--version')}",
        "Python " + platform.python_version() + ": " + ", ".join(f"{name} {installed(name)}" for name in PACKAGES),
        f"crate: dynibo {crate}",
        f"C and C++: {first_line('c++', '--version')}, {' '.join(flags)} (Pinocchio -DNDEBUG besides)",
        f"Rust: {first_line('rustc', '--version')}, release, {rustflags}, lto",
        f"processor: {processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}",
    ]
