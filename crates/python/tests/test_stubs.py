"""The stubs say what the package has."""

import ast
import inspect
import sys
from pathlib import Path

import punctual3d
import pytest
from punctual3d import _punctual3d

STUBS = ast.parse((Path(punctual3d.__file__).parent / "_punctual3d.pyi").read_text())
CLASSES = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")}
FUNCTIONS = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}


def arguments(function):
    """Names, and whether they have to be given by name, whether they can be left out."""
    args = function.args
    required = len(args.args) - len(args.defaults)
    plain = [(arg.arg, False, i >= required) for i, arg in enumerate(args.args) if arg.arg not in ("self", "cls")]
    return plain + [(arg.arg, True, default is not None) for arg, default in zip(args.kwonlyargs, args.kw_defaults)]


def signature(function):
    parameters = inspect.signature(function).parameters.values()
    return [
        (p.name, p.kind is p.KEYWORD_ONLY, p.default is not p.empty)
        for p in parameters
        if p.name not in ("self", "cls")
    ]


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_the_same_names():
    assert public(dir(_punctual3d)) == set(CLASSES) | public(FUNCTIONS)
    shown = public(punctual3d.__all__) - {"shapes"}
    assert shown | set(punctual3d.shapes.__all__) == public(dir(_punctual3d))
    assert all(getattr(_punctual3d, name).__doc__ for name in public(dir(_punctual3d)))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions(name):
    assert signature(getattr(_punctual3d, name)) == arguments(FUNCTIONS[name])


@pytest.mark.parametrize("name", CLASSES)
def test_classes(name):
    real, stub = getattr(_punctual3d, name), CLASSES[name]
    if issubclass(real, Exception):
        return
    members = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
    assert public(vars(real)) == public(members)
    if "__new__" in members:
        # Before, such classes do not tell theirs.
        assert sys.version_info < (3, 10) or signature(real) == arguments(members["__new__"])
    else:
        with pytest.raises(TypeError, match="[Nn]o constructor|cannot create"):
            real()
    for member in public(members):
        is_property = any(getattr(d, "id", "") == "property" for d in members[member].decorator_list)
        assert getattr(real, member).__doc__, member
        if not is_property:
            assert signature(getattr(real, member)) == arguments(members[member])
