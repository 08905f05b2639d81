"""Writes the contents of a package as SPDX 2.3 in JSON: its files with checksums, and its third-party parts.

    sbom.py --name NAME --version VERSION --in PACKAGE[,PACKAGE...] --source FOLDER --output FILE [--root DIR]
            [--prefix DIR] [--without PART]... [--strict] FILE...

Licences, suppliers and names of the parts come from the table of docs/licences.md; their versions come from Debian's
packages and web/package-lock.json. PARTs are parts that this build does not include. Only shared libraries can be
detected in the FILEs: statically linked and header-only parts are known from the table alone. A shared library that a
FILE needs and the table lacks, or that no package owns, is an error with --strict; otherwise it is listed without
version and licence, with a warning. An npm part of the pages that the table lacks is an error. The same files give the
same bytes: the date is SOURCE_DATE_EPOCH, or the current time if that is not set. File names are relative to the
prefix; on this machine the prefix is below the root.
"""
import argparse
import datetime
import functools
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

OURS = {"program": "`fascicle` and its library", "library": "`fascicle` and its library", "python": "the Python module",
        "development": "`fascicle` and its library", "mesher": "`fascicle-mesher`"}


@functools.cache
def words_of(*command):
    """A command's output; empty if it fails or does not exist."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def table_after(text, heading):
    """The rows of the table whose heading starts like this, as dictionaries."""
    lines = text.splitlines()
    start = next((i for i, line in enumerate(lines) if line.startswith(heading)), None)
    if start is None:
        sys.exit(f"sbom: docs/licences.md has no table that begins with {heading}")
    cells = lambda line: [cell.strip() for cell in line.strip("|").split("|")]
    rows = []
    for line in lines[start + 2:]:
        if not line.startswith("|"):
            break
        rows.append(dict(zip(cells(lines[start]), cells(line))))
    return rows


def parts_from_npm(lock):
    """Names and versions of what the pages contain."""
    return {path.removeprefix("node_modules/"): part["version"] for path, part in lock["packages"].items()
            if path and not part.get("dev") and not part.get("devOptional")}


def debian_source(package):
    return words_of("dpkg-query", "-W", "-f=${source:Package}\n", package).partition("\n")[0]


def owner_of(place):
    """The package that owns a file; empty if none does."""
    for line in words_of("dpkg-query", "-S", str(place)).splitlines():
        # Diversions are listed before the packages.
        if not re.match(r"(local )?diversion ", line):
            return line.partition(": ")[0].partition(",")[0]
    return ""


def linked_sources(file):
    """The Debian source packages of the shared libraries that a file needs, by library name."""
    folders = [pathlib.Path(path) for path in re.findall(r"SEARCH_DIR\(\"=?([^\"]*)\"\)", words_of("ld", "--verbose"))]
    found = {}
    for name in re.findall(r"\(NEEDED\).*\[(.*)\]", words_of("readelf", "--dynamic", "--wide", file)):
        # ld knows the folders, except that of the loader, which belongs to the C library.
        places = [folder / name for folder in [*folders, pathlib.Path("/lib64")] if (folder / name).exists()]
        owner = ""
        for place in dict.fromkeys(path for p in places for path in (p, p.resolve())):
            owner = owner or owner_of(place)
        found[name] = debian_source(owner) if owner else ""
    return found


def sha(kind, data):
    return hashlib.new(kind, data).hexdigest()


def identifier(*words):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", "-".join(words)).strip("-")


def file_entries(root, prefix, files):
    entries = []
    for path in sorted(pathlib.Path(root + file) for file in files):
        name = "/" + os.path.relpath(path, root + prefix)
        if path.is_symlink() or not path.is_file():
            continue
        data = path.read_bytes()
        entries.append({"SPDXID": identifier("File", sha("sha1", name.encode())[:12], path.name),
                        "fileName": "." + name,
                        "checksums": [{"algorithm": kind.upper(), "checksumValue": sha(kind, data)}
                                      for kind in ("sha1", "sha256")],
                        "licenseConcluded": "NOASSERTION", "licenseInfoInFiles": ["NOASSERTION"],
                        "copyrightText": "NOASSERTION"})
    return entries


def part_entry(row, npm):
    """The entry of a third-party part, with references to its packages."""
    package = row["package"]
    if package.startswith("npm:"):
        package = package.removeprefix("npm:")
        version, place = npm.get(package, ""), f"pkg:npm/{package}"
        download = f"https://registry.npmjs.org/{package}/-/{package}-{version}.tgz"
    else:
        version, place = words_of("dpkg-query", "-W", "-f=${Version}\n", package).partition("\n")[0], ""
        source = debian_source(package)
        place = f"pkg:deb/debian/{source or package}"
        download = f"https://tracker.debian.org/pkg/{source}" if source else "NOASSERTION"
    entry = {"SPDXID": identifier("Part", row["part"]), "name": row["part"], "versionInfo": version or "NOASSERTION",
             "supplier": "Organization: " + row["supplier"], "downloadLocation": download, "filesAnalyzed": False,
             "licenseConcluded": row["licence"], "licenseDeclared": row["licence"], "copyrightText": "NOASSERTION"}
    if version:
        entry["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                  "referenceLocator": f"{place}@{version.replace('+', '%2B').replace(':', '%3A')}"}]
    return entry


def unknown_entry(library):
    """The entry of a library that belongs to no known part."""
    return {"SPDXID": identifier("Library", library), "name": library, "versionInfo": "NOASSERTION",
            "supplier": "NOASSERTION", "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
            "licenseConcluded": "NOASSERTION", "licenseDeclared": "NOASSERTION", "copyrightText": "NOASSERTION"}


def document_of(name, version, inside, source, root, prefix, files, without=(), is_strict=True):
    text = (source / "docs" / "licences.md").read_text(encoding="utf-8")
    licences = {row["program or library"]: row["licence of the binary"]
                for row in table_after(text, "| program or library |")}
    held = lambda row: {word.strip() for word in row["in"].split(",")}
    table = table_after(text, "| part |")
    for part in without:
        if part not in {row["part"] for row in table}:
            sys.exit(f"sbom: docs/licences.md does not name {part}, which this build goes without")
    rows = [row for row in table if held(row) & set(inside) and row["part"] not in without]
    npm = parts_from_npm(json.loads((source / "web" / "package-lock.json").read_text(encoding="utf-8")))
    named = {row["package"].removeprefix("npm:") for row in table}
    for part in npm:
        if part not in named:
            sys.exit(f"sbom: the pages contain {part}, which docs/licences.md does not name")

    entries = file_entries(root, prefix, files)
    linked = {}
    for entry in entries:
        linked.update(linked_sources(root + prefix + entry["fileName"][1:]))
    sources = {debian_source(row["package"]): row["part"] for row in rows if not row["package"].startswith("npm:")}
    # Packages that are not installed have no source.
    sources.pop("", None)
    dynamic, unknown = set(), []
    for library, of in linked.items():
        if library.startswith("libfascicle.so"):
            continue
        if of in sources:
            dynamic.add(sources[of])
        elif words_of("dpkg-query", "--version"):
            fault = (f"{name} needs {library} (of {of or 'no package'}), which docs/licences.md does not name "
                     f"for {', '.join(inside)}")
            if is_strict:
                sys.exit(f"sbom: {fault}")
            print(f"sbom: {fault}; it is listed without version and licence", file=sys.stderr)
            unknown.append(unknown_entry(library))

    expression = " AND ".join(sorted({licences[OURS[package]] for package in inside}))
    ours = {"SPDXID": identifier("Package", name), "name": name, "versionInfo": version,
            "supplier": "Organization: fascicle", "downloadLocation": "NOASSERTION", "filesAnalyzed": True,
            "packageVerificationCode": {"packageVerificationCodeValue": sha("sha1", "".join(
                sorted(entry["checksums"][0]["checksumValue"] for entry in entries)).encode())},
            "licenseConcluded": expression, "licenseDeclared": expression, "copyrightText": "NOASSERTION",
            "hasFiles": [entry["SPDXID"] for entry in entries]}
    if not entries:
        ours["filesAnalyzed"] = False
        del ours["packageVerificationCode"], ours["hasFiles"]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                  "relatedSpdxElement": ours["SPDXID"]}]
    relations += [{"spdxElementId": ours["SPDXID"], "relationshipType": "CONTAINS",
                   "relatedSpdxElement": entry["SPDXID"]} for entry in entries]
    parts = [part_entry(row, npm) for row in rows]
    for part in parts:
        kind = "DYNAMIC_LINK" if part["name"] in dynamic else "STATIC_LINK"
        if "npm" in part["downloadLocation"]:
            kind = "CONTAINS"
        relations.append({"spdxElementId": ours["SPDXID"], "relationshipType": kind,
                          "relatedSpdxElement": part["SPDXID"]})
    relations += [{"spdxElementId": ours["SPDXID"], "relationshipType": "DYNAMIC_LINK",
                   "relatedSpdxElement": library["SPDXID"]} for library in unknown]
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    when = (datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc) if epoch
            else datetime.datetime.now(datetime.timezone.utc))
    document = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
                "name": f"{name}-{version}", "documentNamespace": "",
                "creationInfo": {"created": when.strftime("%Y-%m-%dT%H:%M:%SZ"),
                                 "creators": ["Organization: fascicle", f"Tool: fascicle-sbom-{version}"]},
                "packages": [ours, *parts, *unknown], "files": entries, "relationships": relations}
    # Different documents get different names.
    content = sha("sha256", json.dumps(document, sort_keys=True).encode())
    document["documentNamespace"] = f"https://fascicle.invalid/spdx/{name}-{version}-{content[:32]}"
    return document


def main():
    parser = argparse.ArgumentParser()
    for option in ("--name", "--version", "--in", "--source", "--output"):
        parser.add_argument(option, required=True, dest="inside" if option == "--in" else option[2:])
    parser.add_argument("--root", default="")
    parser.add_argument("--prefix", default="")
    parser.add_argument("--without", action="append", default=[])
    parser.add_argument("--strict", action="store_true")
    parser.add_argument("files", nargs="*")
    given = parser.parse_args()
    document = document_of(given.name, given.version, given.inside.split(","), pathlib.Path(given.source),
                           given.root.rstrip("/"), given.prefix.rstrip("/"), given.files, given.without, given.strict)
    part = pathlib.Path(given.root.rstrip("/") + given.output + ".part")
    part.parent.mkdir(parents=True, exist_ok=True)
    part.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    part.replace(str(part).removesuffix(".part"))


if __name__ == "__main__":
    main()
