# SPDX-License-Identifier: BSD-3-Clause
# All third-party packages but ROS and Eigen, so that each has one place.
find_package(TBB QUIET CONFIG)
find_package(yaml-cpp REQUIRED)
find_package(Ceres REQUIRED)
find_package(PCL REQUIRED COMPONENTS common kdtree search filters sample_consensus features registration io)
find_package(GeographicLib REQUIRED)
find_package(PNG REQUIRED)
find_package(GDAL QUIET)  # optional: of the format geotiff
find_package(SQLite3 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(nanoflann REQUIRED)
find_package(CLI11 QUIET)
find_package(Threads REQUIRED)
find_package(embree 3 REQUIRED)
find_package(Boost REQUIRED COMPONENTS iostreams)

# Third-party headers as system headers: this package's warnings are for its own code.
function(lidar_mapping_import name)
  cmake_parse_arguments(ARG "" "" "INCLUDES;LIBRARIES" ${ARGN})
  add_library(${name} INTERFACE IMPORTED)
  target_include_directories(${name} SYSTEM INTERFACE ${ARG_INCLUDES})
  target_link_libraries(${name} INTERFACE ${ARG_LIBRARIES})
endfunction()

set(pcl_core_libraries ${PCL_COMMON_LIBRARIES} ${PCL_KDTREE_LIBRARIES} ${PCL_SEARCH_LIBRARIES}
    ${PCL_OCTREE_LIBRARIES} ${PCL_FILTERS_LIBRARIES} ${PCL_SAMPLE_CONSENSUS_LIBRARIES}
    ${PCL_FEATURES_LIBRARIES})
lidar_mapping_import(lidar_mapping_pcl INCLUDES ${PCL_INCLUDE_DIRS} LIBRARIES ${pcl_core_libraries})
lidar_mapping_import(lidar_mapping_pcl_registration INCLUDES ${PCL_INCLUDE_DIRS}
                     LIBRARIES ${pcl_core_libraries} ${PCL_REGISTRATION_LIBRARIES})
lidar_mapping_import(lidar_mapping_pcl_io INCLUDES ${PCL_INCLUDE_DIRS}
                     LIBRARIES ${pcl_core_libraries} ${PCL_IO_LIBRARIES})
lidar_mapping_import(lidar_mapping_geographiclib INCLUDES ${GeographicLib_INCLUDE_DIRS}
                     LIBRARIES ${GeographicLib_LIBRARIES})
if(GDAL_FOUND)
  lidar_mapping_import(lidar_mapping_gdal INCLUDES ${GDAL_INCLUDE_DIRS} LIBRARIES ${GDAL_LIBRARIES})
endif()
# SuiteSparse's sparse Cholesky, which Ceres builds on, has no package file of its own.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
lidar_mapping_import(lidar_mapping_cholmod INCLUDES ${CHOLMOD_INCLUDE_DIR}
                     LIBRARIES ${CHOLMOD_LIBRARY})
if(catkin_FOUND)
  # Of the chunks of bags and MCAP files; zlib has the checksums of the latter.
  find_package(BZip2 REQUIRED)
  find_package(ZLIB REQUIRED)
  find_path(LZ4_INCLUDE_DIR lz4.h REQUIRED)
  find_library(LZ4_LIBRARY lz4 REQUIRED)
  find_path(ZSTD_INCLUDE_DIR zstd.h REQUIRED)
  find_library(ZSTD_LIBRARY zstd REQUIRED)
  lidar_mapping_import(lidar_mapping_compression
    INCLUDES ${LZ4_INCLUDE_DIR} ${BZIP2_INCLUDE_DIR} ${ZSTD_INCLUDE_DIR}
    LIBRARIES ${LZ4_LIBRARY} ${BZIP2_LIBRARIES} ${ZSTD_LIBRARY} ZLIB::ZLIB)
  lidar_mapping_import(lidar_mapping_catkin INCLUDES ${catkin_INCLUDE_DIRS}
                       LIBRARIES ${catkin_LIBRARIES})
endif()

# What Ubuntu 20.04 packages without a target, under another name, or not at all.
if(NOT TARGET TBB::tbb)
  find_path(TBB_INCLUDE_DIR tbb/task_arena.h REQUIRED)
  find_library(TBB_LIBRARY tbb REQUIRED)
  lidar_mapping_import(TBB::tbb INCLUDES ${TBB_INCLUDE_DIR} LIBRARIES ${TBB_LIBRARY})
endif()
if(NOT TARGET Ceres::ceres)
  lidar_mapping_import(Ceres::ceres INCLUDES ${CERES_INCLUDE_DIRS} LIBRARIES ${CERES_LIBRARIES})
endif()
if(NOT TARGET CLI11::CLI11)
  include(FetchContent)
  FetchContent_Declare(CLI11 GIT_REPOSITORY https://github.com/CLIUtils/CLI11.git GIT_TAG v2.1.2)
  FetchContent_MakeAvailable(CLI11)
endif()

if(catkin_FOUND)
  set(LIDAR_MAPPING_TESTING ${CATKIN_ENABLE_TESTING})
else()
  include(CTest)
  set(LIDAR_MAPPING_TESTING ${BUILD_TESTING})
endif()
if(LIDAR_MAPPING_TESTING)
  find_package(GTest REQUIRED)
  # CMake before 3.20 calls it by another name.
  if(NOT TARGET GTest::gtest)
    lidar_mapping_import(GTest::gtest LIBRARIES GTest::GTest)
  endif()
endif()
