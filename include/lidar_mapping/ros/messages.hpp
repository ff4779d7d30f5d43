// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Vector3.h>
#include <ros/service_traits.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>

// The package's own messages and services. The generated headers put them into the namespace of
// the values that they carry, under the same names (lidar_mapping::KeyFrame), so a file cannot see
// both; here the generated aliases get the suffix `Message`. Include this header instead of the
// generated ones.
#define Floor FloorMessage
#define FrontEndStatus FrontEndStatusMessage
#define KeyFrame KeyFrameMessage
#define KeyFramePoses KeyFramePosesMessage
#define LocalizationStatus LocalizationStatusMessage
#define Loop LoopMessage
#define LoopVerdict LoopVerdictMessage
#define SyncedInputs SyncedInputsMessage
#include <lidar_mapping/DumpGraph.h>
#include <lidar_mapping/Floor.h>
#include <lidar_mapping/FrontEndStatus.h>
#include <lidar_mapping/GetKeyFrames.h>
#include <lidar_mapping/KeyFrame.h>
#include <lidar_mapping/KeyFramePoses.h>
#include <lidar_mapping/LoadGraph.h>
#include <lidar_mapping/LoadMap.h>
#include <lidar_mapping/LocalizationStatus.h>
#include <lidar_mapping/Loop.h>
#include <lidar_mapping/LoopVerdict.h>
#include <lidar_mapping/OptimizeMap.h>
#include <lidar_mapping/Relocalize.h>
#include <lidar_mapping/SaveMap.h>
#include <lidar_mapping/SaveSession.h>
#include <lidar_mapping/SyncedInputs.h>
#undef Floor
#undef FrontEndStatus
#undef KeyFrame
#undef KeyFramePoses
#undef LocalizationStatus
#undef Loop
#undef LoopVerdict
#undef SyncedInputs
