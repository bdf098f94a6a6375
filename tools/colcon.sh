#!/usr/bin/env bash
# Build both packages with colcon against ROS 2 from PyPI, in VENV, and try what it built.
# usage: tools/colcon.sh VENV
set -euo pipefail
cd "$(dirname "$0")/.."
venv=$(realpath -s "$1")
export VIRTUAL_ENV=$venv PATH=$venv/bin:$PATH

# ROS 2 from PyPI needs the same mends here as inside pip; a ROS installation needs none of these arguments.
colcon build --cmake-args -G Ninja -DBUILD_TESTING=OFF \
  "-DPython3_EXECUTABLE=$venv/bin/python" \
  "-DCMAKE_PROJECT_hybrid_dynamics_msgs_INCLUDE=$PWD/msg_defs/cmake/pip_build.cmake"

set +u # the script of colcon reads variables that may be unset
source install/setup.bash
set -u

python tools/try_install.py install
