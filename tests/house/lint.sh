#!/bin/sh
# clang-format on all our sources and clang-tidy on those of the program. Arguments: a configured build folder (for its
# compile commands), and how many sources clang-tidy checks, most recently changed first (default: all).
set -eu
build=$1
most=${2:-100000}
files=$(git ls-files '*.cpp' '*.hpp' '*.h' '*.c')
echo "clang-format"
# shellcheck disable=SC2086
clang-format --dry-run -Werror $files
echo "clang-tidy"
git log --format= --name-only -- '*.cpp' | grep -v '^tests/' | awk '!seen[$0]++' |
  while read -r file; do [ ! -f "$file" ] || echo "$file"; done | head -n "$most" |
  xargs -P "$(nproc)" -n 1 clang-tidy -p "$build" --quiet --extra-arg=-Wno-unknown-warning-option 2>/dev/null
echo "lint: clean"
