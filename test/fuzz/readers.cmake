# SPDX-License-Identifier: BSD-3-Clause
# What reads files: compiled once more with the sanitizers, so that the fuzz programs find what
# damaged files do to it. The rest of the package stays as it is built for use. `readers_root` is
# the folder of the package.
set(reader_sources
  ${readers_root}/src/pose_graph/files/binary_graph_reader.cpp
  ${readers_root}/src/pose_graph/files/g2o_file.cpp
  ${readers_root}/src/common/csv.cpp
  ${readers_root}/src/common/input_file.cpp
  ${readers_root}/src/common/number_words.cpp
  ${readers_root}/src/common/pcd_header.cpp
  ${readers_root}/src/common/trajectory.cpp
  ${readers_root}/src/config/load.cpp
  ${readers_root}/src/config/overlay.cpp
  ${readers_root}/src/config/schema.cpp
  ${readers_root}/src/config/value.cpp
  ${readers_root}/src/pipeline/doubt/doubt_file.cpp
  ${readers_root}/src/pipeline/folders/folder_input.cpp
  ${readers_root}/src/pipeline/folders/hdl_dump_reading.cpp
  ${readers_root}/src/pipeline/folders/kitti_folder.cpp
  ${readers_root}/src/pipeline/folders/kitti_raw.cpp
  ${readers_root}/src/preprocessing/gnss/nmea.cpp
  ${readers_root}/src/ros/bags/bag_chunk.cpp
  ${readers_root}/src/ros/bags/bag_file.cpp
  ${readers_root}/src/ros/bags/bag_set.cpp
  ${readers_root}/src/ros/bags/bag_stream.cpp
  ${readers_root}/src/preprocessing/packets/hesai_calibration.cpp
  ${readers_root}/src/preprocessing/packets/hesai_models.cpp
  ${readers_root}/src/preprocessing/packets/hesai_packets.cpp
  ${readers_root}/src/preprocessing/packets/ouster_packets.cpp
  ${readers_root}/src/preprocessing/packets/packet_decoding.cpp
  ${readers_root}/src/preprocessing/packets/velodyne_calibration.cpp
  ${readers_root}/src/preprocessing/packets/velodyne_models.cpp
  ${readers_root}/src/preprocessing/packets/velodyne_packets.cpp
  ${readers_root}/src/ros/bags/cdr_message.cpp
  ${readers_root}/src/ros/bags/chunked_recording.cpp
  ${readers_root}/src/ros/clouds/cloud_reader.cpp
  ${readers_root}/src/ros/bags/file_bytes.cpp
  ${readers_root}/src/ros/clouds/hesai_scan.cpp
  ${readers_root}/src/ros/clouds/livox_cloud.cpp
  ${readers_root}/src/ros/bags/mcap_content.cpp
  ${readers_root}/src/ros/bags/mcap_file.cpp
  ${readers_root}/src/ros/bags/mcap_index.cpp
  ${readers_root}/src/ros/bags/mcap_records.cpp
  ${readers_root}/src/ros/bags/message_layout.cpp
  ${readers_root}/src/ros/checks/moving_frame.cpp
  ${readers_root}/src/ros/inputs/odometry_choice.cpp
  ${readers_root}/src/ros/clouds/ouster_clock.cpp
  ${readers_root}/src/ros/inputs/ouster_messages.cpp
  ${readers_root}/src/ros/clouds/ouster_metadata.cpp
  ${readers_root}/src/ros/inputs/ouster_topics.cpp
  ${readers_root}/src/ros/clouds/ouster_turns.cpp
  ${readers_root}/src/ros/clouds/point_cloud1.cpp
  ${readers_root}/src/ros/clouds/point_cloud_decoder.cpp
  ${readers_root}/src/ros/clouds/point_fields.cpp
  ${readers_root}/src/ros/clouds/point_times.cpp
  ${readers_root}/src/ros/clouds/recorded_cloud.cpp
  ${readers_root}/src/ros/bags/recorded_frames.cpp
  ${readers_root}/src/ros/bags/ros2_file.cpp
  ${readers_root}/src/ros/bags/ros2_types.cpp
  ${readers_root}/src/ros/conversions/sensor_conversions.cpp
  ${readers_root}/src/ros/inputs/sensor_inputs.cpp
  ${readers_root}/src/ros/clouds/time_fields.cpp
  ${readers_root}/src/ros/clouds/velodyne_scan.cpp
  ${readers_root}/src/session/cloud_store.cpp
  ${readers_root}/src/session/database.cpp
  ${readers_root}/src/session/loop_files.cpp
  ${readers_root}/src/session/pcd_file.cpp
  ${readers_root}/src/session/pcd_points.cpp
  ${readers_root}/src/session/session.cpp
  ${readers_root}/src/session/session_folder.cpp
  ${readers_root}/src/session/session_reading.cpp
  ${readers_root}/src/session/session_schema.cpp
  ${readers_root}/src/map_import/map_input.cpp
  ${readers_root}/src/map_import/map_points.cpp
  ${readers_root}/src/recordings/bag_input.cpp
  ${readers_root}/src/recordings/other_lidars.cpp
  ${readers_root}/src/campaign/campaign_case.cpp
  ${readers_root}/src/tools/parameters/config_path.cpp
  ${readers_root}/src/recordings/pcd_scan.cpp
  ${readers_root}/src/report/examined_drive.cpp
  ${readers_root}/src/report/localization_record.cpp
  ${readers_root}/src/report/run_record.cpp
  ${readers_root}/src/tools/parameters/stage_files.cpp)

# A number beyond the range of the type that it is put into is no error of `undefined`.
set(reader_sanitizers address,undefined,float-cast-overflow)
set(reader_sanitizer_options -Og -g1 -fno-omit-frame-pointer -ffp-contract=off
  -fno-sanitize-recover=undefined,float-cast-overflow)

function(lidar_mapping_sanitized_library name)
  add_library(${name} SHARED EXCLUDE_FROM_ALL ${reader_sources})
  # Those of a folder are compiled as one, but for those that share names there. (libFuzzer's project
  # does not know which do.)
  get_property(separate GLOBAL PROPERTY LIDAR_MAPPING_SEPARATE)
  if(separate)
    set_target_properties(${name} PROPERTIES UNITY_BUILD_MODE GROUP)
    foreach(source ${reader_sources})
      if(NOT source IN_LIST separate)
        get_filename_component(folder ${source} DIRECTORY)
        string(MAKE_C_IDENTIFIER "${folder}" group)
        set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
      endif()
    endforeach()
  else()
    set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
  endif()
  target_compile_options(${name} PUBLIC -fsanitize=${reader_sanitizers} ${reader_sanitizer_options})
  # The checks of the sanitizers hide from GCC that what it warns of is never read.
  target_compile_options(${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(${name} PUBLIC -fsanitize=${reader_sanitizers})
  if(LIDAR_MAPPING_PRECOMPILE)
    target_precompile_headers(${name} PRIVATE ${LIDAR_MAPPING_COMMON_HEADERS}
                                              ${LIDAR_MAPPING_MESSAGE_HEADERS})
  endif()
endfunction()
