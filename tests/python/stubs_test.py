"""The stubs match the module by names and signatures, and every public object has a docstring."""

import ast
import inspect
import os
import unittest

import fascicle

FOLDER = os.path.dirname(fascicle.__file__)


def shape_of(arguments):
    """Names, kinds and defaults of arguments, without types and without the names behind stars."""
    defaults = [None] * (len(arguments.args) - len(arguments.defaults)) + arguments.defaults
    shape = [("positional", a.arg, d and ast.unparse(d)) for a, d in zip(arguments.args, defaults)]
    shape += [("keyword", a.arg, d and ast.unparse(d)) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return shape + [(kind, "", None) for kind, a in (("*", arguments.vararg), ("**", arguments.kwarg)) if a]


def shape_of_native(function):
    """The same for a compiled function, from the first line of its docstring."""
    line = function.__doc__.splitlines()[0].replace(": fascicle._fascicle.", ": ")
    return shape_of(ast.parse(f"def {line}: ...").body[0].args)


def shape_of_python(function):
    """The same for a Python function. A default that is a function becomes `...`, as in the stub."""
    parameters = inspect.signature(function).parameters.values()
    kept = [p.replace(annotation=p.empty, default=Ellipsis if inspect.isfunction(p.default) else p.default)
            for p in parameters]
    shown = str(inspect.Signature(kept)).replace("Ellipsis", "...")
    return shape_of(ast.parse(f"def f{shown}: ...").body[0].args)


def same(stub, real):
    """Whether two signatures agree; a stub's `...` matches any default."""
    return len(stub) == len(real) and all(
        a[:2] == b[:2] and (a[2] == b[2] or (a[2] == "..." and b[2] is not None)) for a, b in zip(stub, real))


def stub_tree():
    with open(os.path.join(FOLDER, "__init__.pyi")) as file:
        return ast.parse(file.read())


def is_property(node):
    return any(isinstance(d, ast.Name) and d.id == "property" for d in node.decorator_list)


def differences(tree):
    """Differences between the stub and the module, as texts."""
    found, public = [], set()
    for node in tree.body:
        if isinstance(node, ast.AnnAssign):
            public.add(node.target.id)
            if type(getattr(fascicle, node.target.id, None)).__name__ != node.annotation.id:
                found.append(node.target.id)
        elif isinstance(node, ast.FunctionDef):
            public.add(node.name)
            real = getattr(fascicle, node.name, None)
            shape = real and (shape_of_python(real) if inspect.isfunction(real) else shape_of_native(real))
            if shape is None or not same(shape_of(node.args), shape):
                found.append(f"{node.name}: {shape}")
        elif isinstance(node, ast.ClassDef):
            public.add(node.name)
            found += differences_of_class(node)
    public -= {"__version__"}
    found += sorted(public.symmetric_difference(fascicle.__all__))
    return found


def differences_of_class(node):
    real = getattr(fascicle, node.name, None)
    if real is None:
        return [node.name]
    found = []
    if issubclass(real, Exception):
        bases = [ast.unparse(b) for b in node.bases]
        return [] if bases == [b.__name__ for b in real.__bases__] else [f"{node.name}: {real.__bases__}"]
    members = [n for n in node.body if isinstance(n, ast.FunctionDef)]
    for member in members:
        here = f"{node.name}.{member.name}"
        one = inspect.getattr_static(real, member.name, None)
        if one is None or isinstance(one, property) != is_property(member):
            found.append(here)
        elif not is_property(member):
            function = getattr(real, member.name)
            shape = shape_of_python(function) if inspect.isfunction(function) else shape_of_native(function)
            if not same(shape_of(member.args), shape):
                found.append(f"{here}: {shape}")
    public = {name for name in vars(real) if not name.startswith("_")}
    return found + [f"{node.name}.{name}" for name in sorted(public - {m.name for m in members})]


class Stubs(unittest.TestCase):
    def test_agree_with_the_module(self):
        self.assertEqual(differences(stub_tree()), [])

    def test_what_differs_is_seen(self):
        for before, after in [("def step_clip(self)", "def step_clap(self)"), ("jumps: bool = False", "jumps: bool = True"),
                              ("time: float | None = None, jumps", "jumps"), ("threads: int = 0,\n", "thread: int = 0,\n"),
                              ("    @property\n    def unit(", "    def unit("), ("solver_version: int", "solver_version: str"),
                              ("class Cancelled(Error)", "class Cancelled(BadInput)"), ("def formats()", "def format()")]:
            with open(os.path.join(FOLDER, "__init__.pyi")) as file:
                text = file.read()
            self.assertIn(before, text)
            self.assertNotEqual(differences(ast.parse(text.replace(before, after))), [], after)

    def test_everything_public_has_words(self):
        for name in fascicle.__all__:
            one = getattr(fascicle, name)
            if not callable(one):
                continue
            self.assertTrue(one.__doc__, name)
            for member, value in vars(one).items() if inspect.isclass(one) else ():
                if not member.startswith("_") and (callable(value) or isinstance(value, (property, staticmethod))):
                    words = getattr(one, member).__doc__ if not isinstance(value, property) else value.__doc__
                    self.assertTrue(words and len(words.splitlines()[-1]) > 10, f"{name}.{member}")

    def test_is_marked_as_typed(self):
        self.assertTrue(os.path.exists(os.path.join(FOLDER, "py.typed")))


if __name__ == "__main__":
    unittest.main()
