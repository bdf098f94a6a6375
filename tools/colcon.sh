#!/usr/bin/env bash
# Build both packages with colcon against ROS 2 from PyPI, in VENV, and try what it built.
# usage: tools/colcon.sh VENV
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$(realpath -s "$1")
export VIRTUAL_ENV=$venv PATH=$venv/bin:$PATH

# Aside from build/ and install/ of the usual colcon build, and anew: a CMake cache names the environment it is for.
base=build/colcon
rm -rf "$base"

# ROS 2 from PyPI needs the same mends here as inside pip; a ROS installation needs none of the CMake arguments.
colcon --log-base "$base/log" build --build-base "$base/build" --install-base "$base/install" \
  --cmake-args -G Ninja -DBUILD_TESTING=OFF \
  "-DPython3_EXECUTABLE=$venv/bin/python" \
  "-DCMAKE_PROJECT_hybrid_dynamics_msgs_INCLUDE=$PWD/msg_defs/cmake/pip_build.cmake"

set +u # the script of colcon reads variables that may be unset
source "$base/install/setup.bash"
set -u
python tools/try_install.py "$base/install"
