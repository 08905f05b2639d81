"""portable_contents.py FOLDER: checks the component list of the portable pair (cmake/sbom.py): every file with its
checksum, the statically linked libraries, and the libraries next to the programs."""

import hashlib
import json
import os
import sys

LIST = "fascicle.spdx.json"
folder = sys.argv[1]
with open(os.path.join(folder, LIST), encoding="utf-8") as file:
    listed = json.load(file)
sums = {}
for name in sorted(os.listdir(folder)):
    if name != LIST:
        with open(os.path.join(folder, name), "rb") as file:
            sums["./" + name] = hashlib.sha256(file.read()).hexdigest()
named = {entry["fileName"]: checksum["checksumValue"] for entry in listed["files"]
         for checksum in entry["checksums"] if checksum["algorithm"] == "SHA256"}
if named != sums:
    sys.exit("%s: differs from what lies beside it: %s" % (LIST, sorted(set(named.items()) ^ set(sums.items()))))
names = {package["SPDXID"]: package["name"] for package in listed["packages"]}
kinds = {names.get(relation["relatedSpdxElement"], ""): relation["relationshipType"]
         for relation in listed["relationships"]}
for part, kind in {"libpng": "STATIC_LINK", "zlib": "STATIC_LINK", "GMP": "STATIC_LINK", "TetGen": "DYNAMIC_LINK",
                   "GNU C library": "DYNAMIC_LINK", "assimp": None}.items():
    if kinds.get(part) != kind:
        sys.exit("%s: %s is %s, and not %s" % (LIST, part, kinds.get(part), kind))
