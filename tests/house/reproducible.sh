#!/bin/sh
# Builds are reproducible: one commit gives the same bytes in any folder and at any time.
#   reproducible.sh [TARGET...]        builds HEAD twice, in folders of other names and depths and without ccache, and
#                                      compares all release files including packages; or only files of these targets
#   reproducible.sh --packages FOLDER  packs the build in FOLDER twice, some seconds apart, and compares
# FASCICLE_CMAKE: more arguments for CMake.
set -eu
cd "$(dirname "$0")/../.."
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Release files below a folder.
given_away() { # FOLDER
  (cd "$1" && find -L . -maxdepth 3 -type f \( -name 'fascicle' -o -name 'fascicle-mesher' -o -name 'fascicle-convert' \
    -o -name 'libfascicle.so.*.*.*' -o -name '_fascicle*.so' -o -name 'fascicle-blender.zip' -o -name '*.deb' \
    -o -name '*.a' \) ! -path '*_CPack_Packages*' | sort)
}

same_names() { # A B
  given_away "$1" > "$work/files"
  given_away "$2" > "$work/files-of-other"
  cmp -s "$work/files" "$work/files-of-other"
}

# Compares the release files below two folders.
compare() { # A B
  differ=0
  # The control: a file in only one folder is detected.
  mkdir -p "$work/control/one" "$work/control/other"
  touch "$work/control/other/fascicle-mesher"
  ! same_names "$work/control/one" "$work/control/other" || { echo "reproducible: a file more is not seen" >&2; exit 1; }
  if ! same_names "$1" "$2"; then
    echo "reproducible: one of the two has other files:" >&2
    diff "$work/files" "$work/files-of-other" >&2 || true
    differ=1
  fi
  while read -r file; do
    if [ ! -f "$2/$file" ]; then
      continue
    elif cmp -s "$1/$file" "$2/$file"; then
      echo "$(sha256sum < "$1/$file" | cut -c 1-64)  $file"
    else
      echo "reproducible: $file differs" >&2
      differ=1
    fi
  done < "$work/files"
  [ -s "$work/files" ] || { echo "reproducible: there is nothing to compare" >&2; exit 1; }
  # The control: an extra byte is detected.
  file=$(comm -12 "$work/files" "$work/files-of-other" | head -n 1)
  [ -n "$file" ] || { echo "reproducible: the two have no file in common" >&2; exit 1; }
  { cat "$2/$file"; echo; } > "$work/longer"
  ! cmp -s "$1/$file" "$work/longer" || { echo "reproducible: a byte more is not seen" >&2; exit 1; }
  return $differ
}

if [ "${1:-}" = --packages ]; then
  build=$(cd "$2" && pwd)
  version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")
  for turn in first second; do
    mkdir -p "$work/$turn"
    (cd "$build" && cpack -B "$work/$turn") > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
    rm -rf "$work/$turn/_CPack_Packages"
    # The packages hold the add-on that is built already. Other tests read it, so it is packed again elsewhere.
    # shellcheck disable=SC2046
    python3 -B blender/pack.py "$work/$turn/fascicle-blender.zip" "$version" LICENSE blender/fascicle \
      $(cd blender/fascicle && echo *.py)
    # Timestamps in the files have a resolution of one second, in zip of two.
    [ "$turn" = second ] || sleep 3
  done
  cmp "$work/first/fascicle-blender.zip" "$build/fascicle-blender.zip" >&2
  compare "$work/first" "$work/second"
  exit
fi

for place in a b/in/a/deeper/folder; do
  source=$work/$place/source build=$work/$place/source/build/release
  # One build folder is inside the source folder, the other next to it.
  [ "$place" = a ] || build=$work/$place/another
  mkdir -p "$source"
  git archive HEAD | tar -x -C "$source"
  # shellcheck disable=SC2086
  cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DFASCICLE_TESTS=OFF \
    -DCMAKE_INSTALL_PREFIX=/usr ${FASCICLE_CMAKE:-} >&2
  CCACHE_DISABLE=1 cmake --build "$build" ${*:+--target "$@"} >&2
  [ $# -gt 0 ] || (cd "$build" && cpack -B "$build/packages") >&2
  # Only the location may differ.
  ln -s "$build" "$work/built-$(echo "$place" | cut -c 1)"
done
compare "$work/built-a" "$work/built-b"
