"""Converts settings of a scene to the library's form: strings such as 'layers.fat.alpha=0.2'."""

import math
import os
from collections.abc import Mapping

# Short escapes of TOML's basic strings; other control characters are written by number.
_escapes = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def _quoted(text):
    def escaped(c):
        return _escapes.get(c) or (f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c)

    return '"' + "".join(map(escaped, text)) + '"'


def value_text(value, path):
    """A value as TOML."""
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    if isinstance(value, (str, os.PathLike)):
        return _quoted(os.fspath(value))
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_quoted(str(k))} = {value_text(v, f'{path}.{k}')}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(value_text(v, path) for v in value) + "]"
    raise TypeError(f"{path}: {value!r} is no value of a scene file")


def _is_key(key, path):
    # "solver.substeps" names a key of a table; inside a table, a dot would be part of a name.
    parts = key.split(".") if isinstance(key, str) and not path else [key]
    return all(isinstance(part, str) and part and "." not in part and "=" not in part for part in parts)


def _flat(table, path):
    for key, value in table.items():
        if not _is_key(key, path):
            raise ValueError(f"{path or 'set'}: {key!r} is no key of a scene file")
        inner = f"{path}.{key}" if path else key
        if isinstance(value, Mapping) and value:
            yield from _flat(value, inner)
        else:
            yield f"{inner}={value_text(value, inner)}"


def settings(set, tables):
    """The strings for `set`, a mapping or a list of strings, then those for tables of the scene file by name."""
    if set is None:
        texts = []
    elif isinstance(set, Mapping):
        texts = list(_flat(set, ""))
    elif isinstance(set, str):
        texts = [set]
    else:
        texts = list(set)
    for name, table in tables.items():
        if not isinstance(table, Mapping):
            raise TypeError(f"unexpected argument {name!r}; tables of the scene file are given as mappings")
        texts += _flat(table, name)
    for text in texts:
        if not isinstance(text, str):
            raise TypeError(f"set: {text!r} is no str such as 'layers.fat.alpha=0.2'")
        if "\0" in text:
            raise ValueError(f"{text!r}: a setting cannot hold a NUL character")
    return texts
