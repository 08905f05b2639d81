#!/bin/sh
# Long forms of tests that CI runs briefly; argument: a build folder with tests. About an hour on 2 cores.
set -eu
build=$1
# 20,000 random bodies per property; CI runs 50.
RC_PARAMS="max_success=20000 verbose_progress=0" "$build/test_properties"
# Damaged meshes, scenes and FBX and Collada files, with 20 seeds each.
for test in test_mesh:MeshFile.SurvivesDamage test_scene:'SceneFuzz.*' test_convert:'FromBlender.*damaged*'; do
  "$build/${test%%:*}" --gtest_filter="${test#*:}" --gtest_shuffle --gtest_random_seed=1 --gtest_repeat=20
done
# Characters, and presets of a scene, that CI skips.
"$build/test_flesh" --gtest_filter='*Soak.*'
"$build/test_studio" --gtest_filter='*Soak.*'
"$build/test_build" --gtest_filter='*Soak*'
# Device failures at 200 different calls.
FASCICLE_FAULT_POINTS=200 "$build/test_cli" --gtest_filter='DeviceFaults.*'
# Ten million damaged messages to the studio.
FASCICLE_FUZZ_MESSAGES=10000000 "$build/test_studio" --gtest_filter='Commands.Fuzz*'
# All scenes on all devices, and all code at -O0 and -O3, of which CI builds the solver alone; a minute of scene time
# instead of ten seconds.
cmake --build "$build" --target frame_hashes_O0 frame_hashes_O3_native
FASCICLE_EXACTNESS_FRAMES=3600 "$build/test_exactness"
echo "soak: all passed"
