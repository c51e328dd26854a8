"""Loads the extension, and says in words why it cannot be loaded: it is of one version of Python and one kind of system."""

import importlib
import pathlib
import sys
import sysconfig

_NAME = f"{__package__}._native"


def _explain() -> str:
    folder = pathlib.Path(__file__).parent
    there = sorted(path.name[len("_native."):-len(".so")] for path in folder.glob("_native.*.so"))
    here = str(sysconfig.get_config_var("EXT_SUFFIX")).strip(".").rpartition(".")[0]
    if not there:
        return (f"{folder} holds no extension, so it is the package's source; build the target `sideray_python` and set "
                "PYTHONPATH=build/python, or install a wheel")
    return (f"{folder} is for {' and '.join(there)}, and {sys.executable} is {here}; install the wheel for it: "
            f"{sys.executable} -m pip install sideray-*-cp{sys.version_info[0]}{sys.version_info[1]}-*.whl")


try:
    importlib.import_module(_NAME)
except ModuleNotFoundError as error:
    if error.name != _NAME:
        raise
    raise ImportError(f"sideray: {_explain()}", name=_NAME) from None
except ImportError as error:
    raise ImportError(f"sideray: its extension cannot be loaded: {error}; install a wheel made for this system, or the "
                      "package of that library", name=_NAME) from error
