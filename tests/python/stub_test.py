"""The stub of the extension, and the annotations of what is written in Python, agree with what is there."""

import ast
import inspect
import pathlib
import re
import typing

import pytest

import sideray
from sideray import _native

STUB = pathlib.Path(sideray.__file__).with_name("_native.pyi")
LOOKS = {"__init__"}


def stubbed():
    """Of the stub: {name: parameters}, {class: {member: parameters, or None of a property}}."""
    functions, classes = {}, {}
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.FunctionDef):
            functions[node.name] = [argument.arg for argument in node.args.args]
        elif isinstance(node, ast.ClassDef):
            classes[node.name] = {
                member.name: None if member.decorator_list else [argument.arg for argument in member.args.args][1:]
                for member in node.body if isinstance(member, ast.FunctionDef)}
    return functions, classes


def parameters(function):
    """As pybind11 writes them into the first line of the docstring."""
    line = function.__doc__.splitlines()[0]
    inside = line[line.index("(") + 1:line.rindex(") ->")]
    depth, parts, part = 0, [], ""
    for character in inside:
        depth += (character in "[(") - (character in "])")
        if character == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += character
    names = [re.match(r"\s*(\w+)", p)[1] for p in [*parts, part] if p.strip()]
    return [name for name in names if name not in ("self", "arg0")] or names[1:]


def public(of):
    return {name for name, value in vars(of).items() if name in LOOKS or not name.startswith("_")}


def test_functions_and_their_parameters():
    functions, classes = stubbed()
    there = {name for name in public(_native)}
    assert there == set(functions) | set(classes)
    for name, expected in functions.items():
        assert parameters(getattr(_native, name)) == expected, name


@pytest.mark.parametrize("name", sorted(stubbed()[1]))
def test_classes_and_their_members(name):
    expected, real = stubbed()[1][name], getattr(_native, name)
    # Classes that cannot be made from Python have an __init__ that says so.
    assert public(real) - ({"__init__"} - set(expected)) == set(expected)
    for member, names in expected.items():
        if names is None:
            assert isinstance(getattr(real, member), property), member
        elif member != "__init__" or names:
            assert parameters(getattr(real, member)) == names, member


def test_annotations_of_the_package_name_what_exists():
    for name in sideray.__all__:
        value = getattr(sideray, name)
        assert value.__doc__ if inspect.isclass(value) or inspect.isfunction(value) else True, name
        members = [m for k, m in vars(value).items() if inspect.isfunction(m)] if inspect.isclass(value) else []
        for function in [value] * inspect.isfunction(value) + members:
            typing.get_type_hints(function)


def test_public_functions_say_what_they_take():
    for name in sideray.__all__:
        value = getattr(sideray, name)
        if not inspect.isclass(value) or issubclass(value, (Exception, int, tuple)):
            continue
        for member, function in vars(value).items():
            if not member.startswith("_") and (callable(function) or isinstance(function, property)):
                assert getattr(function, "__doc__", None), f"{name}.{member}"


def test_the_package_is_marked_as_typed():
    assert STUB.with_name("py.typed").exists()


def test_options_are_typed():
    """Names and words of the options, as type checkers know them, are those of the table."""
    typed = {}
    for node in ast.parse(STUB.with_name("_options.pyi").read_text()).body:
        if isinstance(node, ast.ClassDef) and node.name == "RenderOptions":
            for member in node.body:
                constants = [part.value for part in ast.walk(member.annotation) if isinstance(part, ast.Constant)]
                words = [value for value in constants if isinstance(value, str)]
                typed[member.target.id] = words, {part.id for part in ast.walk(member.annotation) if isinstance(part, ast.Name)}
    numbers = {"switch": "bool", "flag": "bool", "integer": "int", "number": "float", "text": "str", "choice": "Literal"}
    assert list(typed) == [name for name in sideray.option_names() if name != "ray_traced"]
    for name, (words, names) in typed.items():
        row = sideray.option(name)
        assert words == ([] if row["type"] == "switch" else row["choices"]), name
        assert numbers[row["type"]] in names, name
