#!/bin/sh
# Checks contents and dependencies of the Debian packages in a folder. Prints each package; stops at the first error.
#   check_packages.sh DIR
set -eu
cd "$1"

fail() {
  echo "check_packages: $*" >&2
  exit 1
}

# PACKAGE FILE...: the package contains these files.
holds() {
  package=$1
  shift
  deb=$(ls "${package}"_*.deb) || fail "there is no package $package"
  for file in "$@"; do
    dpkg-deb -c "$deb" | awk '{print $6}' | grep -Eq "^\\./$file\$" || fail "$package lacks $file"
  done
}
# PACKAGE WORD...: its dependencies contain these words, or with a leading ! do not.
depends() {
  deb=$(ls "${1}"_*.deb)
  all=$(dpkg-deb -f "$deb" Depends)
  shift
  for word in "$@"; do
    case $word in
      !*) ! echo "$all" | grep -q -- "${word#!}" || fail "$deb depends on ${word#!}: $all" ;;
      *) echo "$all" | grep -q -- "$word" || fail "$deb does not depend on $word: $all" ;;
    esac
  done
}

holds fascicle usr/bin/fascicle usr/share/man/man1/fascicle.1 usr/share/bash-completion/completions/fascicle \
  usr/share/zsh/vendor-completions/_fascicle usr/share/fish/vendor_completions.d/fascicle.fish \
  usr/share/doc/fascicle/copyright usr/share/fascicle/fascicle-blender.zip
holds libfascicle0 'usr/lib/[^/]*/libfascicle.so.0' usr/share/doc/libfascicle0/copyright
holds libfascicle-dev usr/include/fascicle/fascicle.h usr/include/fascicle/fascicle.hpp \
  'usr/lib/[^/]*/libfascicle.so' 'usr/lib/[^/]*/cmake/fascicle/fascicle-config.cmake' \
  'usr/lib/[^/]*/pkgconfig/fascicle.pc' usr/share/doc/libfascicle-dev/copyright
holds python3-fascicle usr/lib/python3/dist-packages/fascicle/__init__.py \
  usr/lib/python3/dist-packages/fascicle/__init__.pyi usr/lib/python3/dist-packages/fascicle/py.typed \
  'usr/lib/python3/dist-packages/fascicle/_fascicle\.cpython-3[0-9]*-[^/]*\.so' \
  usr/share/doc/python3-fascicle/copyright usr/share/doc/python3-fascicle/examples/sweep.py
holds fascicle-mesher usr/bin/fascicle-mesher usr/share/doc/fascicle-mesher/copyright

dpkg-deb --ctrl-tarfile libfascicle0_*.deb | tar -xO ./shlibs | grep -q '^libfascicle 0 libfascicle0 (>= ' ||
  fail "libfascicle0 does not tell its dependants of itself"
depends fascicle libc6 libstdc++6 libpng !libtet !libgmp
depends libfascicle0 libc6 libdraco !libtet !libgmp !libpng
depends libfascicle-dev 'libfascicle0 (= '
depends python3-fascicle 'libfascicle0 (= ' libc6 'python3 (>= 3\.' 'python3 (<< 3\.' python3-numpy !libdraco !libpython
depends fascicle-mesher libtet1.5
grep -q "Affero" <<TEXT || fail "the mesher's copyright is not its own"
$(dpkg-deb --fsys-tarfile fascicle-mesher_*.deb | tar -xO ./usr/share/doc/fascicle-mesher/copyright)
TEXT
grep -q "three.js authors" <<TEXT || fail "the program's copyright has no notice of three.js"
$(dpkg-deb --fsys-tarfile fascicle_*.deb | tar -xO ./usr/share/doc/fascicle/copyright)
TEXT
for deb in *.deb; do
  package=$(dpkg-deb -f "$deb" Package)
  holds "$package" "usr/share/doc/$package/$package.spdx.json"
  grep -q "\"name\": \"$package-" "${deb%.deb}.spdx.json" || fail "there is no list of what is in $package beside it"
done
sha256sum --quiet -c SHA256SUMS || fail "SHA256SUMS are not those of the files"
[ "$(wc -l < SHA256SUMS)" -eq "$(ls -- *.deb *.spdx.json *.zip | wc -l)" ] || fail "SHA256SUMS leaves files out"
for deb in *.deb; do
  # No file is in two packages.
  dpkg-deb -c "$deb" | awk '$1 !~ /^d/ {print $6}'
done | sort | uniq -d | grep . && fail "a file is in two packages"
for deb in *.deb; do echo "$(dpkg-deb -f "$deb" Package Version | tr '\n' ' ')needs $(dpkg-deb -f "$deb" Depends)"; done
