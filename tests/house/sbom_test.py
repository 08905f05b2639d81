"""The lists of what is in each package (cmake/sbom.py): valid, true to what is installed, and refused where
docs/licences.md does not know a part.

Environment: FASCICLE_CMAKE, FASCICLE_BINARY_DIR, FASCICLE_SOURCE_DIR.
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
EPOCH = "1700000000"


def faults_of(document):
    """What SPDX 2.3 asks for and the document lacks; the fields are those of its clauses 6, 7, 8 and 11."""
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
        need(where, package, "supplier", "^(Organization|Person): .")
        for licence in ("licenseConcluded", "licenseDeclared"):
            need(where, package, licence, r"^[A-Za-z0-9.-]+( (AND|OR|WITH) [A-Za-z0-9.-]+)*$")
        need(where, package, "filesAnalyzed", kind=bool)
        # Of a package whose files are listed the verification code is mandatory.
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
            with self.subTest(package):
                prefix = self.folder / component
                document = install(prefix, component)
                self.assertEqual(faults_of(document), [])
                self.assertEqual(document["packages"][0]["name"], package)
                self.check_files(document, prefix)
                self.assertEqual(document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
                self.assertNotIn(str(self.folder), json.dumps(document), "it holds a path of this machine")
                if with_debian:
                    for part in document["packages"]:
                        self.assertNotEqual(part["versionInfo"], "NOASSERTION", part["name"])
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

    def test_what_the_table_does_not_know_is_refused(self):
        prefix = self.folder / "mesher"
        install(prefix, "mesher")
        source = self.folder / "source"
        for name in ("docs/licences.md", "web/package-lock.json"):
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / name, source / name)

        def written():
            return subprocess.run([sys.executable, "-B", str(SOURCE / "cmake/sbom.py"), "--name", "x", "--version", "1",
                                   "--in", "mesher", "--source", str(source), "--output", str(self.folder / "x.json"),
                                   str(prefix / "bin/fascicle-mesher")], capture_output=True, text=True)

        self.assertEqual(written().returncode, 0)
        lock = json.loads((source / "web/package-lock.json").read_text())
        lock["packages"]["node_modules/left-pad"] = {"version": "1.3.0"}
        (source / "web/package-lock.json").write_text(json.dumps(lock))
        refused = written()
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("left-pad", refused.stderr)
        shutil.copy(SOURCE / "web/package-lock.json", source / "web/package-lock.json")
        if shutil.which("dpkg-query") is None:
            self.skipTest("SKIPPED LOUDLY: without dpkg nobody says what a library belongs to")
        page = (source / "docs/licences.md").read_text()
        (source / "docs/licences.md").write_text(re.sub(r"\| TetGen \|.*\n", "", page))
        refused = written()
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("libtet", refused.stderr)


if __name__ == "__main__":
    unittest.main()
