# SPDX-License-Identifier: BSD-3-Clause
# Source this file: roslaunch and rosrun find the built package afterwards.
#   source scripts/setup.bash
export PATH=/usr/bin:$PATH
_lidar_mapping_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
_lidar_mapping_build=${LIDAR_MAPPING_BUILD:-$_lidar_mapping_root/.build}
if [ -d /opt/ros/noetic ]; then
  . /opt/ros/noetic/setup.bash
fi
if [ -f "$_lidar_mapping_build/devel/setup.bash" ]; then
  . "$_lidar_mapping_build/devel/setup.bash"
  # ROS needs a name for this computer that resolves. With a master on another one the loopback would
  # cut the nodes off.
  case ${ROS_MASTER_URI:-} in
    '' | http://localhost | http://localhost[:/]* | http://127.* | http://:*)
      if [ -z "${ROS_HOSTNAME:-}" ]; then export ROS_IP=${ROS_IP:-127.0.0.1}; fi
      ;;
  esac
else
  echo "lidar_mapping is not built yet: run $_lidar_mapping_root/scripts/demo or scripts/test first" >&2
fi
unset _lidar_mapping_root _lidar_mapping_build
