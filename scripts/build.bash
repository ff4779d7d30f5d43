# SPDX-License-Identifier: BSD-3-Clause
# Functions shared by the scripts: install missing packages, build the package in a folder of its
# own. Meant to be sourced.

package_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIDAR_MAPPING_BUILD:-$package_root/.build}

# catkin and its generators start the first python3 of PATH; only the system's one knows ROS.
export PATH=/usr/bin:$PATH

say() { printf '\n== %s\n' "$*"; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

package_list() {
  if [ -d /opt/ros/noetic ]; then
    echo "$package_root/scripts/packages-noetic.txt"
  else
    echo "$package_root/scripts/packages-debian.txt"
  fi
}

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

# install_missing [PACKAGE ...]: those of the list and those given
install_missing() {
  local package missing=()
  for package in $(sed 's/#.*//' "$(package_list)") "$@"; do
    is_installed "$package" || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  say "Installing ${#missing[@]} packages"
  logged packages.log as_root apt-get update -q
  logged packages.log as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends "${missing[@]}"
}

source_ros() {
  # ROS's own scripts use variables that may be unset.
  set +u
  # shellcheck disable=SC1090,SC1091
  if [ -d /opt/ros/noetic ]; then . /opt/ros/noetic/setup.bash; fi
  if [ -f "$build/devel/setup.bash" ]; then . "$build/devel/setup.bash"; fi
  set -u
}

# build_package [CMAKE ARGUMENT ...]
build_package() {
  say "Building in $build"
  source_ros
  local launcher=()
  if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  logged build.log cmake -S "$package_root" -B "$build" "${launcher[@]}" "$@"
  logged build.log cmake --build "$build" -j"$(nproc)"
  source_ros
}

# side_build KIND: the folder of another build than that which is used. The folder build of a package is the
# one in which rosrun does not look, so that it still finds each command once.
side_build() {
  if [ -n "${LIDAR_MAPPING_BUILD:-}" ]; then echo "${build}_$1"; else echo "$package_root/build/$1"; fi
}

# configure_for_clang: the folder of the build that scripts/check_clang and scripts/check_tidy share. It is
# for the warnings of clang; its programs are not run.
configure_for_clang() {
  build=$(side_build clang)
  source_ros
  local launcher=()
  if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  logged configure.log cmake -S "$package_root" -B "$build" "${launcher[@]}" -DLIDAR_MAPPING_WERROR=ON \
    -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DCMAKE_UNITY_BUILD=OFF -DLIDAR_MAPPING_BENCHMARKS=ON
}

# logged FILE COMMAND ...: the output goes to a file; a terminal shows the progress meanwhile; its
# end is shown if the command fails
logged() {
  local log=$build/$1
  shift
  mkdir -p "$build"
  if [ -t 2 ]; then
    "$@" 2>&1 | show_progress "$log"
  else
    "$@" >"$log" 2>&1
  fi || { tail -n 60 "$log"; echo "Failed; all of the output: $log" >&2; return 1; }
}

# show_progress FILE: writes its input to a file, and the newest line about progress (of make,
# of apt-get, of a test program) to standard error, each over the one before
show_progress() {
  local line columns
  local telling='^(\[ *[0-9]+%\]|Get:[0-9]+|Unpacking|Setting up|\[ RUN)'
  columns=$(tput cols 2>/dev/null || echo 80)
  while IFS= read -r line; do
    printf '%s\n' "$line"
    if [[ $line =~ $telling ]]; then printf '\r\033[K%.*s' "$((columns - 1))" "$line" >&2; fi
  done >"$1"
  printf '\r\033[K' >&2
}

# ROS's tools need a name for this machine that resolves; a bare one may have none.
use_loopback() {
  export ROS_IP=127.0.0.1
  unset ROS_HOSTNAME
  # roslaunch looks localhost up; a system fresh from debootstrap has no /etc/hosts.
  if ! getent hosts localhost >/dev/null; then
    say "Adding localhost to /etc/hosts"
    echo '127.0.0.1 localhost' | as_root tee -a /etc/hosts >/dev/null
  fi
}
