"""The component lists of the packages (cmake/sbom.py): they are valid and match what is installed, and a component that
docs/licences.md does not know is refused.

Environment: FASCICLE_CMAKE, FASCICLE_BINARY_DIR, FASCICLE_SOURCE_DIR; FASCICLE_COMPONENTS: the built components,
comma-separated; and FASCICLE_WITHOUT: parts that were not built.
"""
import copy
import datetime
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["FASCICLE_SOURCE_DIR"])
PACKAGES = {"program": "fascicle", "library": "libfascicle0", "development": "libfascicle-dev",
            "mesher": "fascicle-mesher", "python": "python3-fascicle"}
BUILT = os.environ["FASCICLE_COMPONENTS"].split(",")
WITHOUT = {part for part in os.environ["FASCICLE_WITHOUT"].split(",") if part}
EPOCH = "1700000000"


def faults_of(document):
    """What the document lacks by SPDX 2.3; the fields are those of its clauses 6, 7, 8 and 11."""
    faults = []

    def need(where, element, field, pattern=".", kind=str):
        value = element.get(field)
        if not isinstance(value, kind) or (kind is str and not re.search(pattern, value)):
            faults.append(f"{where}.{field}")

    need("document", document, "spdxVersion", "^SPDX-2\\.3$")
    need("document", document, "dataLicense", "^CC0-1\\.0$")
    need("document", document, "SPDXID", "^SPDXRef-DOCUMENT$")
    need("document", document, "name")
    need("document", document, "documentNamespace", "^https?://[^#]+$")
    need("document", document, "creationInfo", kind=dict)
    creation = document.get("creationInfo") or {}
    need("creationInfo", creation, "created", r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
    need("creationInfo", creation, "creators", kind=list)
    for creator in creation.get("creators") or []:
        if not re.match("(Tool|Person|Organization): .", creator):
            faults.append("creationInfo.creators")
    identifier = r"^SPDXRef-[A-Za-z0-9.-]+$"
    for package in document.get("packages", []):
        where = f"package {package.get('name')}"
        need(where, package, "name")
        need(where, package, "SPDXID", identifier)
        need(where, package, "downloadLocation", "^(https://|NOASSERTION$|NONE$)")
        need(where, package, "versionInfo")
        need(where, package, "supplier", "^((Organization|Person): .|NOASSERTION$)")
        for licence in ("licenseConcluded", "licenseDeclared"):
            need(where, package, licence, r"^[A-Za-z0-9.-]+( (AND|OR|WITH) [A-Za-z0-9.-]+)*$")
        need(where, package, "filesAnalyzed", kind=bool)
        # A package with listed files must have a verification code.
        if package.get("filesAnalyzed"):
            need(where, package, "packageVerificationCode", kind=dict)
        for reference in package.get("externalRefs", []):
            need(where, reference, "referenceLocator", r"^pkg:(deb|npm)/[^@ ]+@[^@ ]+$")
    for file in document.get("files", []):
        where = f"file {file.get('fileName')}"
        need(where, file, "fileName", r"^\./[^/]")
        need(where, file, "SPDXID", identifier)
        kinds = {sum_["algorithm"]: sum_["checksumValue"] for sum_ in file.get("checksums", [])}
        if not re.match("^[0-9a-f]{40}$", kinds.get("SHA1", "")):
            faults.append(where + ".SHA1")
    elements = [document, *document.get("packages", []), *document.get("files", [])]
    names = [element.get("SPDXID") for element in elements]
    if len(set(names)) != len(names):
        faults.append("an SPDXID is there twice")
    for relation in document.get("relationships", []):
        for end in ("spdxElementId", "relatedSpdxElement"):
            if relation.get(end) not in names:
                faults.append(f"relationship to {relation.get(end)}, which is not there")
    if not any(r.get("relationshipType") == "DESCRIBES" for r in document.get("relationships", [])):
        faults.append("document describes nothing")
    return faults


def install(prefix, component=None, root=None):
    command = [os.environ["FASCICLE_CMAKE"], "--install", os.environ["FASCICLE_BINARY_DIR"], "--prefix", str(prefix)]
    environment = {**os.environ, "SOURCE_DATE_EPOCH": EPOCH, **({"DESTDIR": str(root)} if root else {})}
    subprocess.run(command + (["--component", component] if component else []), env=environment, check=True,
                   capture_output=True)
    (name,) = pathlib.Path(str(root or "") + str(prefix)).glob("**/*.spdx.json")
    return json.loads(name.read_text())


class Lists(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def check_files(self, document, prefix):
        for file in document["files"]:
            data = (prefix / file["fileName"]).read_bytes()
            sums = {sum_["algorithm"]: sum_["checksumValue"] for sum_ in file["checksums"]}
            self.assertEqual(sums["SHA256"], hashlib.sha256(data).hexdigest(), file["fileName"])
            self.assertEqual(sums["SHA1"], hashlib.sha1(data).hexdigest(), file["fileName"])
        listed = {(prefix / file["fileName"]).resolve() for file in document["files"]}
        there = {path.resolve() for path in prefix.rglob("*")
                 if path.is_file() and not path.is_symlink() and not path.name.endswith(".spdx.json")}
        self.assertEqual(there - listed, set(), "files are missing from the list")

    def parts(self, document, kind=None):
        names = {package["SPDXID"]: package["name"] for package in document["packages"]}
        return {names[r["relatedSpdxElement"]] for r in document["relationships"]
                if r["relatedSpdxElement"] in names and r["relationshipType"] != "DESCRIBES"
                and kind in (None, r["relationshipType"])}

    def test_each_package_has_a_valid_and_true_one(self):
        with_debian = shutil.which("dpkg-query") is not None
        for component, package in PACKAGES.items():
            if component not in BUILT:
                print(f"SKIPPED LOUDLY: {package} is not built")
                continue
            with self.subTest(package):
                prefix = self.folder / component
                document = install(prefix, component)
                self.assertEqual(faults_of(document), [])
                self.assertEqual(document["packages"][0]["name"], package)
                self.check_files(document, prefix)
                self.assertEqual(document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
                self.assertNotIn(str(self.folder), json.dumps(document), "it holds a path of this machine")
                self.assertEqual(self.parts(document) & WITHOUT, set(), "it lists what is not built")
                if with_debian:
                    if component == "mesher":
                        self.assertEqual(document["packages"][0]["licenseConcluded"], "AGPL-3.0-only")
                        self.assertIn("TetGen", self.parts(document, "DYNAMIC_LINK"))
                    if component == "program":
                        self.assertIn("libpng", self.parts(document, "DYNAMIC_LINK"))
                if component == "program":
                    self.assertIn("three.js", self.parts(document, "CONTAINS"))
                    self.assertNotIn("TetGen", self.parts(document))
                if component == "development":
                    self.assertEqual(self.parts(document), set())

    def test_the_same_files_give_the_same_bytes_below_another_root(self):
        first = install("/usr", "mesher", self.folder / "a")
        self.assertEqual(first, install("/usr", "mesher", self.folder / "b/c"))
        self.check_files(first, self.folder / "a/usr")

    def test_a_whole_installation_has_one(self):
        document = install(self.folder / "whole")
        self.assertEqual(faults_of(document), [])
        self.check_files(document, self.folder / "whole")
        self.assertLessEqual({"TetGen", "three.js", "libpng"}, self.parts(document))
        self.assertEqual("pybind11" in self.parts(document), "python" in BUILT)
        self.assertEqual("assimp" in self.parts(document), "assimp" not in WITHOUT)

    def test_each_fault_is_found(self):
        document = install(self.folder / "mesher", "mesher")
        self.assertEqual(faults_of(document), [])
        elements = {"document": lambda d: d, "creationInfo": lambda d: d["creationInfo"],
                    "ours": lambda d: d["packages"][0], "part": lambda d: d["packages"][1],
                    "file": lambda d: d["files"][0]}
        needed = {"document": ["spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo",
                               "relationships"],
                  "creationInfo": ["created", "creators"],
                  "ours": ["name", "SPDXID", "downloadLocation", "packageVerificationCode", "licenseConcluded"],
                  "part": ["name", "SPDXID", "downloadLocation", "versionInfo", "supplier", "licenseDeclared"],
                  "file": ["fileName", "SPDXID", "checksums"]}
        for element, fields in needed.items():
            for field in fields:
                damaged = copy.deepcopy(document)
                del elements[element](damaged)[field]
                self.assertNotEqual(faults_of(damaged), [], f"{element} without {field}")
        datetime.datetime.strptime(document["creationInfo"]["created"], "%Y-%m-%dT%H:%M:%SZ")

    def write_list(self, program, *options, source=SOURCE, programs=None):
        """sbom.py's output for a program as the mesher, and the list; `programs` come first in PATH."""
        list_ = self.folder / "list.json"
        list_.unlink(missing_ok=True)
        path = os.pathsep.join([str(programs)] * (programs is not None) + [os.environ["PATH"]])
        said = subprocess.run([sys.executable, "-B", str(SOURCE / "cmake/sbom.py"), "--name", "x", "--version", "1",
                               "--in", "mesher", "--source", str(source), "--output", str(list_), *options,
                               str(program)], capture_output=True, text=True, env={**os.environ, "PATH": path})
        return said, json.loads(list_.read_text()) if list_.exists() else None

    def installed_mesher(self):
        install(self.folder / "mesher", "mesher")
        return self.folder / "mesher/bin/fascicle-mesher"

    def test_what_the_table_does_not_know_is_refused(self):
        mesher = self.installed_mesher()
        source = self.folder / "source"
        for name in ("docs/licences.md", "web/package-lock.json"):
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / name, source / name)
        said, whole = self.write_list(mesher, source=source)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertEqual(self.parts(whole) - self.parts(self.write_list(mesher, "--without", "CGAL")[1]), {"CGAL"})
        self.assertIn("pugjxml", self.write_list(mesher, "--without", "pugjxml")[0].stderr)
        lock = json.loads((source / "web/package-lock.json").read_text())
        lock["packages"]["node_modules/left-pad"] = {"version": "1.3.0"}
        (source / "web/package-lock.json").write_text(json.dumps(lock))
        refused = self.write_list(mesher, source=source)[0]
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("left-pad", refused.stderr)
        shutil.copy(SOURCE / "web/package-lock.json", source / "web/package-lock.json")
        if shutil.which("dpkg-query") is None:
            self.skipTest("SKIPPED LOUDLY: without dpkg nobody says what a library belongs to")
        page = (source / "docs/licences.md").read_text()
        (source / "docs/licences.md").write_text(re.sub(r"\| TetGen \|.*\n", "", page))
        refused, list_ = self.write_list(mesher, "--strict", source=source)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("libtet", refused.stderr)
        self.assertIsNone(list_)

    def fake_dpkg(self, owners):
        """A fake dpkg-query that knows these packages, each its own source, and prints the requested fields."""
        folder = self.folder / "programs"
        folder.mkdir(exist_ok=True)
        cases = "".join(f"  -S*/{library}.*) printf '{words}' ;;\n" for library, words in owners.items())
        program = folder / "dpkg-query"
        program.write_text("#!/bin/sh\ncase \"$*\" in\n  --version) echo 1 ;;\n" + cases +
                           "  -S*) printf 'libc6:amd64: /x\\n' ;;\n"
                           "  *source:Package*libtet1.5-dev | *Version*libtet1.5-dev) exit 1 ;;\n"
                           "  *source:Package*libc6*) echo glibc ;;\n  *source:Package*libtet1.5*) echo tetgen ;;\n"
                           "  *) echo 1.0 ;;\nesac\n")
        program.chmod(0o755)
        return folder

    def test_a_library_of_no_package_is_listed_as_unknown_and_refused_in_packages(self):
        mesher = self.installed_mesher()
        programs = self.fake_dpkg({"libtet": ""})
        refused, list_ = self.write_list(mesher, "--strict", programs=programs)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("libtet.so.1.5 (of no package)", refused.stderr)
        said, list_ = self.write_list(mesher, programs=programs)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("libtet.so.1.5", said.stderr)
        self.assertEqual(faults_of(list_), [])
        self.assertIn("libtet.so.1.5", self.parts(list_, "DYNAMIC_LINK"))
        self.assertNotIn("TetGen", self.parts(list_, "DYNAMIC_LINK"))
        versions = {package["name"]: package["versionInfo"] for package in list_["packages"]}
        self.assertEqual(versions["TetGen"], "NOASSERTION", "its package is not installed")
        self.assertEqual(versions["libtet.so.1.5"], "NOASSERTION")

    def test_diversions_own_nothing(self):
        sys.path.insert(0, str(SOURCE / "cmake"))
        import sbom
        self.addCleanup(sys.path.remove, str(SOURCE / "cmake"))
        programs = self.fake_dpkg({"libtet": r"diversion by other from: /x\ndiversion by other to: /y\n"
                                             r"libtet1.5:amd64, libother: /x\n"})
        path = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", path)
        os.environ["PATH"] = f"{programs}{os.pathsep}{path}"
        sbom.words_of.cache_clear()
        self.assertEqual(sbom.owner_of("/usr/lib/libtet.so.1.5"), "libtet1.5:amd64")


if __name__ == "__main__":
    unittest.main()
