# SPDX-License-Identifier: BSD-3-Clause
# What find_package(lidar_mapping) of another package needs besides catkin's own: the headers of
# pose_graph use Ceres, whose library is a target that catkin's DEPENDS does not know.
find_package(Ceres REQUIRED)
list(APPEND lidar_mapping_INCLUDE_DIRS ${CERES_INCLUDE_DIRS})
list(APPEND lidar_mapping_LIBRARIES ${CERES_LIBRARIES})
