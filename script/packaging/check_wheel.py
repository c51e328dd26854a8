"""check_wheel.py WHEEL: what a wheel must be, whatever it draws.

At most 30 MB. Every library is inside or every Linux's; none is OpenGL's, which is looked for at run time. Nothing holds
symbols for debuggers. The program may be run. Each library that was put inside has its licence beside it.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

LARGEST = 30_000_000
OLDEST_GLIBC = (2, 36)  # Debian 12's
OF_LINUX = re.compile(r"^(lib(c|m|dl|rt|pthread|stdc\+\+|gcc_s|z)\.so\.\d+|ld-linux-x86-64\.so\.2)$")


def run(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def is_elf(path):
    with path.open("rb") as stream:
        return stream.read(4) == b"\x7fELF"


def faults_of(wheel, tree):
    if os.path.getsize(wheel) > LARGEST:
        yield f"has {os.path.getsize(wheel)} bytes; {LARGEST} is the most"
    tag = re.search(r"manylinux_(\d+)_(\d+)_", wheel)
    if not tag or (int(tag[1]), int(tag[2])) > OLDEST_GLIBC:
        yield "is not for manylinux_2_36 or older; build it on Debian 12"
    binaries = [path for path in tree.rglob("*") if path.is_file() and is_elf(path)]
    inside = {path.name for path in binaries}
    for path in binaries:
        name = path.relative_to(tree)
        dynamic = run("readelf", "-dW", path)
        for needed in re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic):
            if needed not in inside and not OF_LINUX.match(needed):
                yield f"{name} needs {needed}, which is neither inside nor every Linux's"
        for folder in ":".join(re.findall(r"\((?:RUNPATH|RPATH)\).*\[(.*)\]", dynamic)).split(":"):
            if folder and not folder.startswith("$ORIGIN"):
                yield f"{name} looks for libraries in {folder}"
        if re.search(r"\s\.(symtab|debug_info)\s", run("readelf", "-SW", path)):
            yield f"{name} is not stripped"
    program = tree / "sideray" / "bin" / "sideray"
    if not os.access(program, os.X_OK):
        yield "sideray/bin/sideray is not there or may not be run"
    licences = next(tree.glob("*.dist-info")) / "licenses"
    if not (licences / "LICENSE").is_file() or len(list((licences / "bundled").glob("*.txt"))) < 10:
        yield "lacks licences"
    if not list(tree.glob("sideray.libs/libembree*")):
        yield "holds no Embree"


def main(wheel):
    with tempfile.TemporaryDirectory() as scratch:
        run(sys.executable, "-m", "wheel", "unpack", "-d", scratch, wheel)
        faults = list(faults_of(wheel, next(pathlib.Path(scratch).iterdir())))
    for fault in faults:
        print(f"check_wheel: {wheel}: {fault}", file=sys.stderr)
    sys.exit(1 if faults else 0)


main(*sys.argv[1:])
