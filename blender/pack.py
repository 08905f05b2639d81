"""pack.py ZIP VERSION LICENSE FOLDER FILE...: the add-on as Blender installs it. The same files give the same bytes on
every machine: entries in the order of their names, one date, and stored, as compressors differ."""

import ast
import os
import sys
import zipfile


def version_of(source):
    """bl_info's version, read as Blender reads it: without running the file."""
    for statement in ast.parse(source).body:
        if isinstance(statement, ast.Assign) and statement.targets[0].id == "bl_info":
            return ".".join(map(str, ast.literal_eval(statement.value)["version"]))
    raise SystemExit("pack.py: there is no bl_info")


target, version, licence, folder, *files = sys.argv[1:]
with open(os.path.join(folder, "__init__.py"), encoding="utf-8") as file:
    found = version_of(file.read())
if found != version:
    raise SystemExit("pack.py: bl_info says %s, the project is %s" % (found, version))
sources = {"fascicle/" + name: os.path.join(folder, name) for name in files}
sources["fascicle/LICENSE"] = licence
with zipfile.ZipFile(target + ".part", "w", zipfile.ZIP_STORED) as archive:
    for name, path in sorted(sources.items()):
        entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
        entry.create_system = 3
        entry.external_attr = 0o100644 << 16
        with open(path, "rb") as file:
            archive.writestr(entry, file.read())
os.replace(target + ".part", target)
