#!/bin/sh
# Installs the packages of a folder into a minimal Debian, bakes there, and builds the examples there: the hashes must
# be those of this machine. Needs root, debootstrap and a network; takes minutes.
#   try_packages.sh DIR
set -eu
packages=$(cd "$1" && pwd)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT

debootstrap --variant=minbase bookworm "$root" >&2
mkdir "$root/packages"
cp "$packages"/*.deb "$root/packages"
cp /etc/resolv.conf "$root/etc/resolv.conf"
inside() {
  # Without this machine's environment, such as a compiler launcher.
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C DEBIAN_FRONTEND=noninteractive \
    chroot "$root" /bin/sh -euc "cd /tmp; $1"
}
install="apt-get install -y -qq --no-install-recommends"
bar="bar-layers-i"
hash_of="sed -n 's/^position hash of the last frame: //p'"

inside "apt-get update -qq; $install /packages/fascicle_*.deb /packages/fascicle-mesher_*.deb" >&2
of_bar=$(inside "fascicle bake $bar --set scene.end=0.1 -o bar | $hash_of")
of_arm=$(inside "fascicle bake arm --end 0.05 -o arm | $hash_of")
inside "$install /packages/libfascicle*.deb gcc g++ cmake make pkg-config" >&2
inside "cp -r /usr/share/doc/libfascicle-dev/examples . && cmake -S examples -B built && cmake --build built" >&2
inside "cc examples/bake_character.c -o by_pkg_config \$(pkg-config --cflags --libs fascicle)" >&2
for line in "./built/bake_character $bar c scene.end=0.1" "./by_pkg_config $bar d scene.end=0.1" \
  "./built/step_frames $bar scene.end=0.1 | head -n 1"; do
  [ "$(inside "$line")" = "$of_bar" ] || { echo "try_packages: $line: not $of_bar" >&2; exit 1; }
done
[ "$(inside "./built/bake_character arm e scene.end=0.05")" = "$of_arm" ] ||
  { echo "try_packages: the library's arm is not $of_arm" >&2; exit 1; }
inside "$install /packages/python3-fascicle_*.deb" >&2
for scene in "$bar $of_bar 0.1" "arm $of_arm 0.05"; do
  set -- $scene
  by_python=$(inside "python3 -c 'import fascicle; print(fascicle.bake(\"$1\", \"p-$1\", end=$3).position_hash)'")
  [ "$by_python" = "$2" ] || { echo "try_packages: python: $1 is $by_python, not $2" >&2; exit 1; }
done
examples=/usr/share/doc/python3-fascicle/examples
inside "python3 $examples/sweep.py sweep.svg && python3 $examples/drive_by_poses.py arm arm.npy 10" >&2
inside "mkdir in && cp arm/character.glb in && python3 $examples/bake_folder.py in out 0.05" >&2
echo "in an empty Debian: $bar $of_bar, arm $of_arm, by program, find_package, pkg-config and Python"
