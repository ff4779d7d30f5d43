# SPDX-License-Identifier: BSD-3-Clause
# One library per stage, so that the linker holds the layering too.
add_library(lidar_mapping_warnings INTERFACE)
target_compile_options(lidar_mapping_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  $<$<BOOL:${LIDAR_MAPPING_WERROR}>:-Werror>)

# Several sources of a target are compiled as one: most of the time goes into headers and templates that all
# of them use. -DCMAKE_UNITY_BUILD=OFF compiles each by itself, as editors and clang-tidy want it, and is
# quicker where one source is changed again and again.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ON CACHE BOOL "Compile several sources of a target as one")
endif()
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # It takes the sources for headers, whose types are not to have parts of anonymous namespaces, and
  # constants of one for global names that a function of another one hides.
  target_compile_options(lidar_mapping_warnings INTERFACE -Wno-subobject-linkage -Wno-shadow -Wshadow=local)
endif()

# lidar_mapping_separate(a.cpp ...): compiled by themselves in any case, because they have a name in an
# anonymous namespace that another source of their target has, too. All functions below take such sources
# behind SEPARATE.
function(lidar_mapping_separate)
  if(NOT ARGN)
    return()
  endif()
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  # The property holds in this folder alone; test/fuzz compiles some of them, too.
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE separate)
  set_property(GLOBAL APPEND PROPERTY LIDAR_MAPPING_SEPARATE ${separate})
endfunction()

# Headers that are read once for all targets of libraries and programs; tests have more of them
# (test/CMakeLists.txt). They belong to a target that is no shared library, because such a one defines
# a macro of its own.
set(LIDAR_MAPPING_COMMON_HEADERS
    <Eigen/Dense> <algorithm> <functional> <map> <memory> <optional> <string> <vector>)
# Also read once where a folder sets LIDAR_MAPPING_READS_MESSAGES: they take three seconds for each file.
set(LIDAR_MAPPING_MESSAGE_HEADERS
    <filesystem> <sstream> <thread> <diagnostic_msgs/DiagnosticArray.h> <geometry_msgs/TwistStamped.h>
    <nav_msgs/Odometry.h> <nav_msgs/Path.h> <ros/ros.h> <sensor_msgs/Imu.h> <sensor_msgs/NavSatFix.h>
    <sensor_msgs/PointCloud2.h> <visualization_msgs/MarkerArray.h>)

# lidar_mapping_precompiled_headers(NAME HEADERS header ... LIBRARIES libs): reads them once
function(lidar_mapping_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBRARIES" ${ARGN})
  set(source ${PROJECT_BINARY_DIR}/${name}.cpp)
  file(WRITE ${source} "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE Eigen3::Eigen lidar_mapping_warnings ${ARG_LIBRARIES})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

if(LIDAR_MAPPING_PRECOMPILE)
  lidar_mapping_precompiled_headers(lidar_mapping_precompiled HEADERS ${LIDAR_MAPPING_COMMON_HEADERS})
  if(catkin_FOUND)
    lidar_mapping_precompiled_headers(lidar_mapping_precompiled_messages
      HEADERS ${LIDAR_MAPPING_COMMON_HEADERS} ${LIDAR_MAPPING_MESSAGE_HEADERS}
      LIBRARIES lidar_mapping_catkin)
  endif()
endif()

# lidar_mapping_precompile(TARGET OWNER): the target uses the headers that were read for its owner, or
# for the one with messages where its folder asks for these
function(lidar_mapping_precompile target owner)
  if(NOT LIDAR_MAPPING_PRECOMPILE)
    return()
  endif()
  if(LIDAR_MAPPING_READS_MESSAGES)
    string(APPEND owner _messages)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
  # CMake gives programs another option than libraries.
  target_compile_options(${target} PRIVATE -fPIC)
endfunction()

set(LIDAR_MAPPING_LIBRARIES
    lidar_mapping_common lidar_mapping_config lidar_mapping_preprocessing
    lidar_mapping_registration lidar_mapping_front_end lidar_mapping_loop_closing
    lidar_mapping_localization
    lidar_mapping_pose_graph lidar_mapping_back_end lidar_mapping_moving_objects
    lidar_mapping_map lidar_mapping_map_quality lidar_mapping_session lidar_mapping_evaluation
    lidar_mapping_simulation lidar_mapping_pipeline lidar_mapping_ros)

# lidar_mapping_stage(NAME SOURCES a.cpp ... USES common ... [PUBLIC libs] [PRIVATE libs])
function(lidar_mapping_stage name)
  cmake_parse_arguments(ARG "" "" "SOURCES;SEPARATE;USES;PUBLIC;PRIVATE" ${ARGN})
  lidar_mapping_separate(${ARG_SEPARATE})
  set(target lidar_mapping_${name})
  add_library(${target} ${ARG_SOURCES} ${ARG_SEPARATE})
  list(TRANSFORM ARG_USES PREPEND lidar_mapping_)
  target_include_directories(${target}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${ARG_USES} ${ARG_PUBLIC}
                        PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:lidar_mapping_warnings>)
  # Equal bits on machines with and without fused multiply-add.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  lidar_mapping_precompile(${target} lidar_mapping_precompiled)
  if(catkin_FOUND)
    install(TARGETS ${target} ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
            LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
            RUNTIME DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION})
  endif()
endfunction()

# lidar_mapping_room(NAME [SOURCES a.cpp ...] LIBRARIES libs): what several programs share and nobody
# else may use. It is linked into each of them, and its headers lie beside its sources.
function(lidar_mapping_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;SEPARATE;LIBRARIES" ${ARGN})
  lidar_mapping_separate(${ARG_SEPARATE})
  set(target lidar_mapping_${name})
  if(NOT ARG_SOURCES)
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${target} INTERFACE ${ARG_LIBRARIES})
    return()
  endif()
  add_library(${target} STATIC ${ARG_SOURCES} ${ARG_SEPARATE})
  target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${ARG_LIBRARIES} PRIVATE lidar_mapping_warnings)
  if(NOT name STREQUAL test_main)
    lidar_mapping_precompile(${target} lidar_mapping_precompiled)
  endif()
  if(catkin_FOUND)
    add_dependencies(${target} ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
  endif()
endfunction()

# lidar_mapping_test_support(NAME SOURCES a.cpp ... [LIBRARIES libs]): what test programs share
function(lidar_mapping_test_support name)
  lidar_mapping_room(${name} ${ARGN})
  set_target_properties(lidar_mapping_${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  target_include_directories(lidar_mapping_${name} PUBLIC ${PROJECT_SOURCE_DIR}/test/support
                                                          ${GTEST_INCLUDE_DIRS})
endfunction()

# lidar_mapping_executable(NAME SOURCES a.cpp ... LIBRARIES libs): a node or a command
function(lidar_mapping_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;SEPARATE;LIBRARIES" ${ARGN})
  lidar_mapping_separate(${ARG_SEPARATE})
  add_executable(${name} ${ARG_SOURCES} ${ARG_SEPARATE})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} lidar_mapping_warnings)
  lidar_mapping_precompile(${name} lidar_mapping_precompiled)
  if(catkin_FOUND)
    add_dependencies(${name} ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
    set_target_properties(${name} PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION})
    install(TARGETS ${name} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  endif()
endfunction()

# lidar_mapping_test(NAME SOURCES a.cpp ... LIBRARIES libs): one GTest program; it also sees the headers
# that lie beside the sources of the stage that its folder is named after.
function(lidar_mapping_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;SEPARATE;LIBRARIES" ${ARGN})
  lidar_mapping_separate(${ARG_SEPARATE})
  if(catkin_FOUND)
    catkin_add_gtest(${name} ${ARG_SOURCES} ${ARG_SEPARATE} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/test)
    add_dependencies(${name} ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
    target_link_libraries(${name} lidar_mapping_test_main ${ARG_LIBRARIES} lidar_mapping_warnings)
  else()
    add_executable(${name} ${ARG_SOURCES} ${ARG_SEPARATE})
    target_link_libraries(${name} PRIVATE lidar_mapping_test_main ${ARG_LIBRARIES} lidar_mapping_warnings)
    add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/test)
  endif()
  # Whatever takes time lies in the libraries.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  lidar_mapping_precompile(${name} lidar_mapping_test_main)
  # GTest's own value; some of its packages define it for who links them, and headers have to agree.
  target_compile_definitions(${name} PRIVATE GTEST_HAS_PTHREAD=1)
  get_filename_component(stage ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test/support
                                             ${PROJECT_SOURCE_DIR}/src/${stage})
endfunction()
