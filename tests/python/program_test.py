"""The program as a part of the package, and what an installation for another Python says."""

import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig

import pytest

import sideray

PACKAGE = pathlib.Path(sideray.__file__).parent
SOURCE = pathlib.Path(os.environ.get("SIDERAY_SOURCE", pathlib.Path(__file__).parents[2]))

if not (PACKAGE / "bin/sideray").exists():
    pytest.skip("the target `sideray` is not built", allow_module_level=True)


def run(*arguments, env=None):
    return subprocess.run([str(argument) for argument in arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False, env=env)


def of_module(*arguments, env=None):
    return run(sys.executable, "-B", "-m", "sideray", *arguments, env=env)


@pytest.fixture
def copy(tmp_path):
    """A copy of the package's Python files, without extension and program, and a process's environment with it."""
    folder = tmp_path / "sideray"
    shutil.copytree(PACKAGE, folder, ignore=shutil.ignore_patterns("*.so*", "bin", "__pycache__"))
    return folder, {**os.environ, "PYTHONPATH": str(tmp_path)}


def test_module_is_the_program_of_the_same_build():
    program = os.environ.get("SIDERAY_PROGRAM", PACKAGE / "bin/sideray")
    assert (PACKAGE / "bin/sideray").samefile(program)
    assert of_module("--version").stdout == f"sideray {sideray.__version__}\n"
    assert of_module("render", "--help").stdout == run(program, "render", "--help").stdout


def test_module_draws_what_the_program_draws(tmp_path):
    words = ["render", "solids", "--gl", "none", "--size", "96x54"]
    drawn = of_module(*words, "-o", tmp_path / "module.png")
    assert drawn.returncode == 0, drawn.stderr
    assert run(PACKAGE / "bin/sideray", *words, "-o", tmp_path / "program.png").returncode == 0
    assert (tmp_path / "module.png").read_bytes() == (tmp_path / "program.png").read_bytes()


def test_module_hands_on_streams_and_exit_codes(tmp_path):
    for words in (["render", "no-such-file.glb", "-o", tmp_path / "x.png"], ["render", "solids", "--no-such-option"]):
        expected, got = run(PACKAGE / "bin/sideray", *words), of_module(*words)
        assert got.returncode == expected.returncode != 0
        assert (got.stdout, got.stderr) == (expected.stdout, expected.stderr)


def test_program_ends_with_its_reader():
    """Python ignores SIGPIPE, and the program must not: its exit code would be that of a failure to write."""
    command = f"{sys.executable} -B -m sideray render --help; echo $? >&2"
    shell = subprocess.Popen(["bash", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    shell.stdout.close()
    said = shell.stderr.read().split()
    shell.wait()
    shell.stderr.close()
    assert said[-1] == "141", said  # 128 and the number of SIGPIPE


def test_console_script_is_the_module():
    settings = (SOURCE / "pyproject.toml").read_text()
    assert '[project.scripts]\nsideray = "sideray.__main__:main"\n' in settings
    from sideray.__main__ import main
    assert callable(main)


def test_missing_program_is_named(copy):
    folder, environment = copy
    for extension in PACKAGE.glob("*.so*"):
        (folder / extension.name).symlink_to(extension.resolve())
    for libraries in PACKAGE.parent.glob("sideray.libs"):  # of a wheel
        (folder.parent / libraries.name).symlink_to(libraries)
    said = of_module("--version", env=environment)
    assert said.returncode == 1
    assert f"{folder}/bin/sideray: No such file or directory; build the target `sideray`" in said.stderr


def test_another_python_is_told(copy):
    folder, environment = copy
    (folder / "_native.cpython-37m-x86_64-linux-gnu.so").write_bytes(b"")
    said = run(sys.executable, "-B", "-c", "import sideray", env=environment)
    here = sysconfig.get_config_var("EXT_SUFFIX")[1:-len(".so")]
    assert said.stderr.splitlines()[-1] == (
        f"ImportError: sideray: {folder} is for cpython-37m-x86_64-linux-gnu, and {sys.executable} is {here}; install the "
        f"wheel for it: {sys.executable} -m pip install sideray-*-cp{sys.version_info[0]}{sys.version_info[1]}-*.whl")


def test_source_without_extension_is_told(copy):
    folder, environment = copy
    said = run(sys.executable, "-B", "-c", "import sideray", env=environment).stderr.splitlines()[-1]
    assert said.startswith(f"ImportError: sideray: {folder} holds no extension") and "build the target" in said


def test_extension_that_cannot_be_loaded_is_told(copy):
    folder, environment = copy
    (folder / f"_native{sysconfig.get_config_var('EXT_SUFFIX')}").write_bytes(b"no library")
    said = run(sys.executable, "-B", "-c", "import sideray", env=environment).stderr.splitlines()[-1]
    assert said.startswith("ImportError: sideray: its extension cannot be loaded: ") and "install a wheel" in said
