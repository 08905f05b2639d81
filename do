#!/bin/sh
# The single entry point: installs what is missing, configures, builds and runs. Each step is also a plain CMake preset.
#   ./do bake [ARGS...]   build the program and run `fascicle bake ARGS...`
#   ./do test [CTEST...]  build everything and run the tests
#   ./do build [PRESET]   build a preset (default: release)
#   ./do paper [ASSETS]   bake the paper's scenes, measure, draw docs/figures/*, write docs/paper.md (minutes)
#   ./do characters [ASSETS]   bake characters, draw their worst frames beside skinning into docs/characters (minutes)
#   ./do accuracy [ASSETS]   measure the cost and the error of each quality, write docs/design/accuracy.md (minutes)
#   ./do blender          draw docs/figures/blender.png, Blender's window with the add-on, without a display
#   ./do bench [ARGS...]  build the program and those it is compared with, run `fascicle bench ARGS...`
#   ./do kernels [ARGS...]   the same for the kernels alone: `fascicle-bench-kernels ARGS...`
#   ./do peers [ARGS...]  compare contact with Bullet: build and run `fascicle-bench-contact ARGS...` (minutes)
#   ./do plot RESULTS.json PLOT.svg   plot the results of `./do bench --json`; --threads N, --integrator NAME
#   ./do report-picture   draw docs/figures/report.png, a bake's report as Chromium shows it
#   ./do scene-reference  write docs/scene.md, the reference of every scene key
#   ./do rooms            draw docs/figures/rooms.svg, which room includes which; fail if rooms form a cycle
#   ./do touches [stage|format] NAME [COMMIT]   count the files outside tests that name a model array, a scene key, a
#                         stage or a format
#   ./do package [DIR]    build the Debian packages, their SPDX lists of contents and SHA256SUMS, and check them
#   ./do reproducible [TARGET...]   build this commit twice, in two folders, and compare every published file byte by
#                         byte (an hour on two cores), or only the files of these targets; `--packages`: only pack the
#                         result of `./do package` twice (a minute)
#   ./do portable         build for any distribution, source by source, and bake in a root that holds only libc
#   ./do try-packages     install the packages into an empty Debian and bake there (root, network, minutes)
#   ./do lint [N]         run clang-format and clang-tidy over the sources (clang-tidy over the N last changed)
#   ./do web              check the browser pages (types, tests) and rebuild web/bundle
#   ./do studio-bars SCENE [--minutes M]   measure the studio: start times, frame rates, latency of changes, memory
#   ./do view-figure      bake the bear and draw its page, docs/figures/view.png
#   ./do studio-figure    open the bear in the studio and draw its page, docs/figures/studio.png, and studio-beside.png
#   ./do site             build the pages as a web site in build/site (mkdocs)
#   ./do farm [JOBS]      run a batch of 60 clips on a one-node Slurm with disturbances, compare it with an undisturbed
#                         run, write docs/farm-slurm.txt (root, minutes)
#   ./do reliability [ROW...]   kill, stop and damage bakes and fill their disks a thousand times, bake untrusted files,
#                         bake under Vulkan's validation layer and Valgrind; write docs/reliability.md (hours)
#   ./do mutants [ROOM...] [--count N | --again] [--write]   mutation testing: plant small faults one at a time and
#                         check that the tests find them, or only those that survived before; --write records the
#                         faults that survive in docs/tests.md (hours)
#   ./do sanitize [PRESET] [--write] [SUITE...]   run suites of tests, such as bake, under the sanitizers of asan or tsan
#                         and count reports; --write records each suite in docs/tests.md (hours)
#   ./do coverage [--write] [--missed] [CTEST...]   run the tests and count the lines of the rooms that they cover;
#                         --write records them in docs/tests.md, --missed lists files (an hour)
#   ./do fuzz [TARGET...] [--runs N] [--seconds N] [--jobs N] [--processes N] [--write]   fuzz the file readers with
#                         libFuzzer, a minute each; --write writes docs/fuzzing.md
#   ./do soak [SHARE]     do all the long runs and update their pages: exactness, reliability, fuzzing, sanitizers,
#                         coverage, mutants, double builds (days); with a share such as 0.01, that share of the
#                         reliability runs, fuzzed files and mutants (most of a day)
set -eu
cd "$(dirname "$0")"

build_packages="g++ cmake ninja-build glslang-tools spirv-tools spirv-headers libvulkan-dev libvulkan-volk-dev \
libeigen3-dev libtomlplusplus-dev libtinygltf-dev nlohmann-json3-dev libcli11-dev libxxhash-dev libtet1.5-dev \
libcgal-dev libpugixml-dev libpng-dev libjpeg-dev zlib1g-dev libdraco-dev libmeshoptimizer-dev libassimp-dev \
pybind11-dev python3-dev libboost-dev"
run_packages="libvulkan1 mesa-vulkan-drivers"
test_packages="libgtest-dev librapidcheck-dev vulkan-validationlayers binutils blender python3-numpy strace \
valgrind slurm-wlm munge xvfb xauth chromium"
bench_packages="libbullet-dev libbenchmark-dev"
lint_packages="clang-format clang-tidy clang"
site_packages="mkdocs"

need() {
  missing=""
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  echo "do: installing$missing" >&2
  root=""
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "do: need root or sudo to install:$missing" >&2; exit 1; }
    root=sudo
  fi
  # Output of apt-get goes to stderr, like everything except the program's own results.
  $root apt-get update -qq >&2
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive $root apt-get install -y -qq --no-install-recommends $missing >&2
}

# Programs from npm that tests use to read our files back: pinned by tests/readers/package-lock.json, installed in the
# build folder. Without a network the tests that need them are skipped, with a message.
readers() { # PRESET
  command -v node >/dev/null && command -v npm >/dev/null || need nodejs npm
  folder=build/$1/readers
  mkdir -p "$folder"
  cp tests/readers/*.mjs "$folder"
  if cmp -s tests/readers/package-lock.json "$folder/package-lock.json" && [ -d "$folder/node_modules" ]; then return 0; fi
  cp tests/readers/package.json tests/readers/package-lock.json "$folder"
  (cd "$folder" && timeout 300 npm ci --ignore-scripts --no-audit --no-fund >&2) ||
    { rm -rf "$folder/node_modules"; echo "do: npm could not install the readers; their tests are skipped" >&2; }
}

# The browser pages with their tools from npm, pinned by web/package-lock.json, in the build folder. Without a network
# the tests that need them are skipped, with a message.
web_tools() { # PRESET
  command -v node >/dev/null && command -v npm >/dev/null || need nodejs npm
  folder=build/$1/web
  mkdir -p "$folder"
  rm -rf "$folder/src" "$folder/tests"
  cp -r web/src web/tests web/*.mjs web/tsconfig.json "$folder"
  if cmp -s web/package-lock.json "$folder/package-lock.json" && [ -d "$folder/node_modules" ]; then return 0; fi
  cp web/package.json web/package-lock.json "$folder"
  (cd "$folder" && timeout 300 npm ci --ignore-scripts --no-audit --no-fund >&2) ||
    { rm -rf "$folder/node_modules"; echo "do: npm could not install the tools of web/; their tests are skipped" >&2; }
}

# The environment variable FASCICLE_CMAKE may contain more arguments for CMake.
build() { # PRESET [CMAKE CACHE ARGUMENTS...]
  preset=$1
  shift
  # shellcheck disable=SC2086
  cmake --preset "$preset" "$@" ${FASCICLE_CMAKE:-} >&2
  cmake --build --preset "$preset" >&2
}

# Packed files get the commit's date, so that the same commit gives the same bytes on any day.
commit_time() {
  SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
  export SOURCE_DATE_EPOCH
}

# Whether /dev/shm and memory have a few GB left, and programs may run there.
has_room_in_memory() {
  [ "$(df -k --output=avail /dev/shm 2>/dev/null | tail -n 1)" -gt 4000000 ] 2>/dev/null || return 1
  [ "$(awk '/^MemAvailable:/ { print $2 }' /proc/meminfo)" -gt 8000000 ] 2>/dev/null || return 1
  tried=$(mktemp -p /dev/shm) || return 1
  printf '#!/bin/sh\n' > "$tried"
  chmod +x "$tried"
  "$tried" 2>/dev/null && runs=0 || runs=1
  rm -f "$tried"
  return $runs
}

command=${1:-help}
[ $# -eq 0 ] || shift
# shellcheck disable=SC2086
case $command in
  bake)
    need $build_packages $run_packages
    # A tree that already builds the tests keeps building them.
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    exec build/release/fascicle bake "$@"
    ;;
  test)
    need $build_packages $run_packages $test_packages
    readers release
    web_tools release
    build release -DFASCICLE_TESTS=ON
    # Tests sync thousands of small files. In memory, those of bakes take a quarter of the time.
    if [ -z "${TMPDIR:-}" ] && has_room_in_memory; then export TMPDIR=/dev/shm; fi
    # One more than there are cores: some tests wait for a time limit or for another process.
    exec ctest --preset release --output-on-failure -j "$(($(nproc) + 1))" "$@"
    ;;
  build)
    need $build_packages $run_packages $test_packages
    build "${1:-release}"
    ;;
  bench | kernels)
    need $build_packages $run_packages $bench_packages
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-} -DFASCICLE_BENCH=ON
    [ "$command" = bench ] || exec build/release/fascicle-bench-kernels "$@"
    exec build/release/fascicle bench "$@"
    ;;
  peers)
    need $build_packages $run_packages $bench_packages
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    cmake --preset release ${set_tests:-} -DFASCICLE_BENCH=ON ${FASCICLE_CMAKE:-} >&2
    cmake --build --preset release --target fascicle fascicle-bench-contact >&2
    exec build/release/fascicle-bench-contact "$@"
    ;;
  paper)
    need $build_packages $run_packages python3
    build release
    exec python3 -B docs/paper.py build/release/fascicle "${1:-../shared/assets}"
    ;;
  characters | accuracy)
    need $build_packages $run_packages python3
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    assets=../shared/assets
    [ $# -eq 0 ] || { assets=$1; shift; }
    script=accuracy
    [ "$command" = accuracy ] || script=character_sheets
    exec python3 -B docs/$script.py build/release/fascicle "$assets" "$@"
    ;;
  blender)
    need $build_packages $run_packages $test_packages
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    exec /usr/bin/python3 -B docs/blender_picture.py build/release docs/figures/blender.png
    ;;
  report-picture)
    need $build_packages $run_packages chromium
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    program=$PWD/build/release/fascicle
    (cd "$folder" && "$program" bake arm -o out/arm && "$program" report out/arm -o arm.html)
    # Chromium's sandbox does not work as root.
    [ "$(id -u)" -ne 0 ] || set -- --no-sandbox
    chromium --headless --disable-gpu --hide-scrollbars --window-size=1280,1000 --user-data-dir="$folder/chromium" "$@" \
      --screenshot="$PWD/docs/figures/report.png" "file://$folder/arm.html"
    ;;
  scene-reference)
    need $build_packages $run_packages
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    build/release/fascicle schema --markdown > docs/scene.md.new
    mv docs/scene.md.new docs/scene.md
    ;;
  rooms)
    need $build_packages $test_packages
    cmake --preset release -DFASCICLE_TESTS=ON >&2
    cmake --build --preset release --target draw_rooms >&2
    exec build/release/draw_rooms . docs/figures/rooms.svg
    ;;
  touches)
    kind=array
    case ${1:-} in stage | format) kind=$1; shift ;; esac
    [ $# -gt 0 ] || { echo "do: touches takes a model array, a scene key, a stage or a format" >&2; exit 2; }
    set -f  # git matches the patterns, also in an older commit
    # Counts where a stage or format is declared or handed on: as an enumerator, a table row, a case or a function, and
    # its own files. Uses of its results are not counted.
    listed() { # PATTERN COMMIT WHERE FILES
      found=$(git grep -nE "$1" "$2" -- $3 | sed "s|^$2:||" |
        grep -vE '^[^:]*:[0-9]+: *(//|#)|_sink\.cpp:[0-9]+:' || true)
      own=$(git ls-tree -r --name-only "$2" -- $4)
      in_files=$({ printf '%s\n' "$found" | cut -d: -f1; printf '%s\n' "$own"; } | grep . | sort -u)
      printf '%s\n' "$in_files" | sed 's/^/  /'
      echo "$name: declared and handed on in $(printf '%s\n' "$in_files" | grep -c .) files," \
        "$(printf '%s\n' "$found" | grep -c . || true) lines beside its own shader or sink"
    }
    name=$1
    if [ $kind = stage ]; then
      listed "(Stage|StageKernel|Kernel)::$1\\b|^  $1,|enum class \w+ \{.*\b$1\b|void (Oracle::Impl::)?$1\(" \
        "${2:-HEAD}" "host/model cpu_reference gpu" "shaders/$1.comp shaders/kernel/$1.inc"
      exit
    elif [ $kind = format ]; then
      listed "make_$1_sink|$1_bytes\\(|FORMAT\\($1\\)|$1_format\\(|\"$1\"|\b$1_sink\.cpp|'$1'" "${2:-HEAD}" \
        "host python include" "host/formats/$1_sink.cpp host/bake/$1_sink.cpp"
      exit
    fi
    # Files that declare, check, hash, store, upload or hand on an array; others compute or use it. In older commits
    # the lanes' files are directly in cpu_reference.
    plumbing="host/model host/bake/model_fi* host/bake/identity.cpp host/bake/scene_json.* host/scene/scene* \
gpu/model_buffers.cpp cpu_reference/*lane_stages.h cpu_reference/*lane_stages.cpp shaders/buffers.h shaders/indexing/buffers.glsl"
    named() { git grep -hwE "(buffer_)?$1" "$2" -- $3 | grep -vcE '^[^:]*:? *//' || true; }
    files() { git grep -lwE "(buffer_)?$1" "$2" -- $3 | wc -l; }
    all="host cpu_reference gpu shaders"
    echo "$1: named in $(files "$1" "${2:-HEAD}" "$all") files;" \
      "declared and handed on in $(files "$1" "${2:-HEAD}" "$plumbing") files, $(named "$1" "${2:-HEAD}" "$plumbing") lines"
    ;;
  plot)
    need python3
    exec python3 -B bench/plot.py "$@"
    ;;
  package)
    need $build_packages dpkg-dev
    out=$PWD/${1:-build/package/packages}
    case ${1:-} in /*) out=$1 ;; esac
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-} -DCMAKE_INSTALL_PREFIX=/usr
    mkdir -p "$out"
    # New packages stay in a separate folder until they are checked, because $out may hold other files.
    new=$(mktemp -d "$out/new.XXXXXX")
    trap 'rm -rf "$new"' EXIT
    packed=0
    commit_time
    (cd build/release && cpack -B "$new") >&2 || packed=$?
    rm -rf "$new/_CPack_Packages"
    # Tests of installed trees rely on the folders of a local prefix, which the Python module is linked for.
    cmake --preset release -DCMAKE_INSTALL_PREFIX=/usr/local -UCMAKE_INSTALL_LIBDIR >&2
    cmake --build --preset release >&2
    [ "$packed" -eq 0 ] || exit "$packed"
    cp build/release/fascicle-blender.zip "$new"
    (cd "$new" && for deb in *.deb; do
      package=$(dpkg-deb -f "$deb" Package)
      dpkg-deb --fsys-tarfile "$deb" | tar -xO "./usr/share/doc/$package/$package.spdx.json" > "${deb%.deb}.spdx.json"
    done && sha256sum -- *.deb *.spdx.json *.zip > SHA256SUMS)
    tests/library/check_packages.sh "$new"
    # The checksums come last, so that every file they name exists.
    mv -f "$new"/*.deb "$new"/*.spdx.json "$new"/*.zip "$out"
    mv -f "$new/SHA256SUMS" "$out"
    ;;
  reproducible)
    need $build_packages dpkg-dev
    if [ "${1:-}" = --packages ]; then
      "$0" package >&2
      cmake --preset release -DCMAKE_INSTALL_PREFIX=/usr >&2
      packed=0
      tests/house/reproducible.sh --packages build/release || packed=$?
      cmake --preset release -DCMAKE_INSTALL_PREFIX=/usr/local -UCMAKE_INSTALL_LIBDIR >&2
      exit "$packed"
    fi
    exec tests/house/reproducible.sh "$@"
    ;;
  portable)
    need $build_packages $test_packages
    build portable
    exec ctest --preset portable
    ;;
  try-packages)
    need debootstrap
    [ -d build/package/packages ] || "$0" package
    exec tests/library/try_packages.sh build/package/packages
    ;;
  lint)
    need $build_packages $test_packages $bench_packages $lint_packages
    # Without unity builds, because clang-tidy reads sources one by one.
    cmake --preset release -B build/lint -DFASCICLE_TESTS=ON -DFASCICLE_BENCH=ON -DCMAKE_UNITY_BUILD=OFF >&2
    exec tests/house/lint.sh build/lint "$@"
    ;;
  web)
    web_tools release
    cd build/release/web
    [ -d node_modules ] || exit 1
    npm run --silent check >&2
    npm test --silent >&2
    npm run --silent build >&2
    cp bundle/* ../../../web/bundle/
    ;;
  studio-bars)
    need $build_packages $run_packages python3
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    exec python3 -B bench/studio_bars.py build/release/fascicle "$@"
    ;;
  view-figure)
    need $build_packages $run_packages chromium
    web_tools release
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    folder=$PWD/build/release/view-figure
    build/release/fascicle bake jump -o "$folder" --end 2 --overwrite --device cpu
    build/release/fascicle view "$folder" -o "$folder.html" --overwrite
    picture=$PWD/docs/figures/view.png
    cd build/release/web
    exec node tests/figure.mjs "$folder.html" "$picture" 76
    ;;
  studio-figure)
    need $build_packages $run_packages chromium
    web_tools release
    [ -f build/release/CMakeCache.txt ] || set_tests="-DFASCICLE_TESTS=OFF"
    build release ${set_tests:-}
    program=$PWD/build/release/fascicle figures=$PWD/docs/figures folder=$PWD/build/release/studio-figure
    "$program" bake jump --end 2 --softness 2 --format none -o "$folder/soft-jump" --overwrite
    cd build/release/web
    node tests/studio_figure.mjs "$program" "$figures/studio.png" jump --end 2
    exec node tests/studio_figure.mjs "$program" "$figures/studio-beside.png" jump --end 2 \
      --beside "$folder/soft-jump"
    ;;
  site)
    need $site_packages
    # The pages and what they link to, in the same folders as here, so that their links work unchanged.
    rm -rf build/site-pages
    git ls-files -co --exclude-standard -- '*.md' LICENSE docs ':(exclude,glob)docs/*.py' ':(exclude,glob)docs/*.json' ':!tests' |
      while read -r file; do
        [ ! -f "$file" ] || { mkdir -p "build/site-pages/$(dirname "$file")" && cp "$file" "build/site-pages/$file"; }
      done
    exec mkdocs build --strict --clean
    ;;
  farm)
    need $build_packages $run_packages $test_packages
    build release -DFASCICLE_TESTS=ON
    program=$PWD/build/release/fascicle transcript=$PWD/docs/farm-slurm.txt
    cd tests/farm
    export FASCICLE_PROGRAM="$program" FASCICLE_FARM_TRANSCRIPT="$transcript" FASCICLE_REQUIRE_SLURM=1
    FASCICLE_FARM_JOBS=${1:-60} exec python3 -B slurm_test.py
    ;;
  reliability)
    need $build_packages $run_packages $test_packages
    build release -DFASCICLE_TESTS=ON
    export FASCICLE_PROGRAM="$PWD/build/release/fascicle"
    FASCICLE_FAILING_CALLS=$(find "$PWD/build/release/tests/reliability" -name 'libfailing_calls.so')
    FASCICLE_PLANTED_FAULTS=$(find "$PWD/build/release" -maxdepth 1 -name planted_faults)
    FASCICLE_FAULT_LAYER=$(find "$PWD/build/release/tests" -name 'fault_layer.json')
    export FASCICLE_FAILING_CALLS FASCICLE_PLANTED_FAULTS FASCICLE_FAULT_LAYER
    cd tests/reliability
    if [ $# -eq 0 ]; then set -- --write; fi
    exec python3 -B reliability.py "$@"
    ;;
  mutants)
    need $build_packages $run_packages $test_packages
    exec python3 -B tests/mutants/mutants.py "$@"
    ;;
  sanitize)
    need $build_packages $run_packages $test_packages
    preset=${1:-asan}
    [ $# -eq 0 ] || shift
    web_tools "$preset"
    readers "$preset"
    build "$preset" -DFASCICLE_TESTS=ON
    # The distribution's Python: Blender, which tests start, finds its Python by PATH.
    exec /usr/bin/python3 -B tests/tested/sanitize.py "$preset" "$@"
    ;;
  coverage)
    need $build_packages $run_packages $test_packages gcovr
    web_tools coverage
    readers coverage
    build coverage -DFASCICLE_TESTS=ON
    exec /usr/bin/python3 -B tests/tested/coverage.py "$@"
    ;;
  fuzz)
    need $build_packages clang python3
    build fuzz
    export FASCICLE_FUZZ_BUILD="$PWD/build/fuzz"
    exec python3 -B tests/fuzz/fuzz.py "$@"
    ;;
  soak)
    need $build_packages $run_packages $test_packages
    build release -DFASCICLE_TESTS=ON
    failed=""
    # A failing step does not stop the others, and none runs without a time limit.
    step() { timeout 24h "$@" || failed="$failed
do: soak: failed, or took more than 24 hours: $*"; }
    counted() { awk "BEGIN { count = int($1 * ${share}); print count > 0 ? count : 1 }"; }
    share=${1:-1}
    # A part of the runs must not replace the figures of all.
    write=""
    [ "$share" != 1 ] || write=--write
    step tests/soak.sh build/release
    step ./do reliability --share "$share" $write
    for target in $(python3 -B tests/fuzz/fuzz.py --list); do
      step ./do fuzz "$target" --runs "$(counted 10000000)" $write
    done
    step ./do sanitize asan --write
    step ./do sanitize tsan --write
    step ./do coverage --write
    step ./do mutants --count "$(counted 40)" $write
    step ./do reproducible
    [ -z "$failed" ] || { echo "$failed" >&2; exit 1; }
    ;;
  *)
    sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
    [ "$command" = help ] || exit 2
    ;;
esac
