#!/bin/sh
# clang-format and clang-tidy over our sources; argument: a configured build folder (for its compile commands).
set -eu
build=$1
files=$(git ls-files '*.cpp' '*.h')
echo "clang-format"
# shellcheck disable=SC2086
clang-format --dry-run -Werror $files
echo "clang-tidy"
git ls-files '*.cpp' | grep -v '^tests/' |
  xargs -P "$(nproc)" -n 4 clang-tidy -p "$build" --quiet --extra-arg=-Wno-unknown-warning-option 2>/dev/null
echo "lint: clean"
