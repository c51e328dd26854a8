"""add_licences.py REPAIRED.whl BUILD_FOLDER OUTPUT_FOLDER: writes the wheel with the licences of all that is in it.

In it are the libraries that auditwheel put into sideray.libs, and what was compiled in: headers, and files embedded as text.
Ninja knows those of the build, dpkg whose they are, and /usr/share/doc/PACKAGE/copyright what Debian says of them. Fails
where a library has none. One file a source package, in dist-info/licenses/bundled, and the texts that they refer to.
"""
import importlib.metadata
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Not in the wheel: they are the system's, whose headers everything includes. The wheel of gcc's runtime is every system's, too.
OF_THE_SYSTEM = re.compile(r"^(glibc|linux|gcc-\d+|gcc-defaults|cross-toolchain-base|python3\S*)$")
COMMON = re.compile(r"/usr/share/common-licenses/([\w.+-]*\w)")


def run(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def fail(text):
    sys.exit(f"add_licences: {text}")


def compiled_in(build):
    """The system's files that the build of the wheel has read."""
    deps = run("ninja", "-C", build, "-t", "deps")
    files = {line.strip() for line in deps.splitlines() if line.startswith("    ")}
    files |= set(run("ninja", "-C", build, "-t", "inputs", "sideray", "sideray_python").splitlines())
    return {os.path.realpath(file) for file in files if file.startswith("/usr/") and os.path.isfile(file)}


def packages_of(patterns):
    """Debian's packages that hold files, {file: package}."""
    found = {}
    patterns = sorted(patterns)
    for first in range(0, len(patterns), 500):
        # Files without a package only change the exit status.
        lines = subprocess.run(["dpkg-query", "-S", *patterns[first:first + 500]], stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL, text=True).stdout.splitlines()
        for line in lines:
            packages, separator, file = line.partition(": ")
            if separator and not packages.startswith("diversion "):
                found[file] = packages.split(", ")[0]
    return found


def source_of(package):
    return run("dpkg-query", "-W", "-f", "${source:Package}", package)


def licence_of_pybind11():
    distribution = importlib.metadata.distribution("pybind11")
    texts = [file for file in distribution.files if re.search(r"LICEN[CS]E", file.name)]
    return pathlib.Path(texts[0].locate())


def main(wheel, build, output):
    with tempfile.TemporaryDirectory() as scratch:
        run(sys.executable, "-m", "wheel", "unpack", "-d", scratch, wheel)
        tree = next(pathlib.Path(scratch).iterdir())
        bundled = next(tree.glob("*.dist-info")) / "licenses" / "bundled"
        bundled.mkdir(parents=True)

        # auditwheel puts eight digits into a library's name.
        names = [re.sub(r"-[0-9a-f]{8}(?=\.so)", "", path.name) for path in sorted(tree.glob("*.libs/*"))]
        libraries = packages_of({f"*/{name}" for name in names})
        packages = set(packages_of(compiled_in(build)).values()) | set(libraries.values())
        for name in names:
            if not any(file.endswith(f"/{name}") for file in libraries):
                fail(f"{name} is in {wheel}, and no package of this system holds it")
        packages.add("python3-glad")  # whose output is compiled in

        licences = {}
        for package in sorted(packages):
            copyright = pathlib.Path("/usr/share/doc", package.partition(":")[0], "copyright")
            source = source_of(package)
            if OF_THE_SYSTEM.match(source):
                continue
            if not copyright.is_file():
                fail(f"{package}, which is in {wheel}, has no {copyright}")
            licences.setdefault(source, copyright)
        texts = set()
        for source, copyright in licences.items():
            shutil.copyfile(copyright, bundled / f"{source}.txt")
            texts |= set(COMMON.findall(copyright.read_text(encoding="utf-8", errors="replace")))
        shutil.copyfile(licence_of_pybind11(), bundled / "pybind11.txt")
        for text in sorted(texts):
            common = pathlib.Path("/usr/share/common-licenses", text)
            if common.is_file():
                (bundled / "common-licenses").mkdir(exist_ok=True)
                shutil.copyfile(common, bundled / "common-licenses" / text)
        print(f"licences of {', '.join([*licences, 'pybind11'])}")
        run(sys.executable, "-m", "wheel", "pack", "-d", output, str(tree))


main(*sys.argv[1:])
